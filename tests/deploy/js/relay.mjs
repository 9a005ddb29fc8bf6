// Passes on what comes, and counts what it has passed on to the side that connects.
import { connect, createServer } from 'node:net';

export class Relay {
  numBytesBack = 0;

  static start(port, target) {
    const relay = new Relay();
    relay.server = createServer((from) => {
      const to = connect(target, '127.0.0.1');
      to.on('data', (part) => (relay.numBytesBack += part.length));
      from.pipe(to);
      to.pipe(from);
      from.on('error', () => to.destroy());
      to.on('error', () => from.destroy());
      from.on('close', () => to.destroy());
      to.on('close', () => from.destroy());
    });
    return new Promise((resolve) => relay.server.listen(port, '127.0.0.1', () => resolve(relay)));
  }
}
