// Passes on what comes, and counts what it has passed on: forth to the target, and back.
import { connect, createServer } from 'node:net';

export class Relay {
  numBytesForth = 0;
  numBytesBack = 0;

  static start(port, target) {
    const relay = new Relay();
    relay.server = createServer((from) => {
      const to = connect(target, '127.0.0.1');
      from.on('data', (part) => (relay.numBytesForth += part.length));
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
