// node webhook_receiver.mjs SECRET_FILE: prints the address of a receiver on loopback, then one line
// per message: its type and data when Standard Webhooks' own library finds the signature good, or what was
// wrong with it. The secret is looked up when a message comes.
import { readFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { Webhook } from 'standardwebhooks';

const [secretFile] = process.argv.slice(2);

const server = createServer((request, response) => {
  const pieces = [];
  request.on('data', (piece) => pieces.push(piece));
  request.on('end', () => {
    try {
      const webhook = new Webhook(readFileSync(secretFile, 'utf8').trim());
      const message = webhook.verify(Buffer.concat(pieces).toString(), request.headers);
      response.writeHead(204).end();
      console.log(`good ${message.type} ${JSON.stringify(message.data)}`);
    } catch (error) {
      response.writeHead(400).end();
      console.log(`bad ${error.message}`);
    }
  });
});
server.listen(0, '127.0.0.1', () => console.log(`http://127.0.0.1:${server.address().port}/`));
