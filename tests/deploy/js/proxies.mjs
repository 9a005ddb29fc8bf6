// The examples of deploy/proxy, started on loopback: only names, ports and certificate are put in.
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { start } from './processes.mjs';

export const programs = { nginx: '/usr/sbin/nginx', caddy: '/usr/bin/caddy' };

// Each must be there to be replaced, so that the examples stay what is tried.
const replaceAll = (text, pairs) =>
  pairs.reduce((all, [from, to]) => {
    if (!all.includes(from)) throw new Error(`the example has no line "${from.trim()}"`);
    return all.replaceAll(from, to);
  }, text);

function startNginx(source, folder, { http, https, server, chain, key }) {
  const text = replaceAll(readFileSync(join(source, 'deploy/proxy/nginx.conf'), 'utf8'), [
    ['    listen [::]:80;\n', ''],
    ['    listen [::]:443 ssl;\n', ''],
    ['listen 80;', `listen 127.0.0.1:${http};`],
    ['listen 443 ssl;', `listen 127.0.0.1:${https} ssl;`],
    ['server 127.0.0.1:8080;', `server 127.0.0.1:${server};`],
    ['server_name lab.example;', 'server_name localhost;'],
    ['/etc/ssl/divemesh/chain.pem', chain],
    ['/etc/ssl/divemesh/key.pem', key],
  ]);
  writeFileSync(join(folder, 'divemesh.conf'), text);
  writeFileSync(
    join(folder, 'nginx.conf'),
    `daemon off; pid ${folder}/nginx.pid; error_log stderr;\nevents {}\nhttp {\n  access_log off;\n` +
      ['client_body', 'proxy', 'fastcgi', 'uwsgi', 'scgi']
        .map((what) => `  ${what}_temp_path ${folder}/${what};\n`)
        .join('') +
      `  include ${folder}/divemesh.conf;\n}\n`,
  );
  return start('nginx', folder, [programs.nginx, '-p', folder, '-c', join(folder, 'nginx.conf'), '-e', 'stderr']);
}

function startCaddy(source, folder, { http, https, server, chain, key }) {
  const text = replaceAll(readFileSync(join(source, 'deploy/proxy/Caddyfile'), 'utf8'), [
    ['\tskip_install_trust', '\tadmin off\n\tdefault_bind 127.0.0.1\n\tskip_install_trust'],
    ['# tls /etc/ssl/divemesh/chain.pem /etc/ssl/divemesh/key.pem', `tls ${chain} ${key}`],
  ]);
  writeFileSync(join(folder, 'Caddyfile'), text);
  return start(
    'caddy',
    folder,
    [programs.caddy, 'run', '--adapter', 'caddyfile', '--config', join(folder, 'Caddyfile')],
    {
      DIVEMESH_HOST: 'localhost',
      DIVEMESH_UPSTREAM: `127.0.0.1:${server}`,
      DIVEMESH_HTTP_PORT: String(http),
      DIVEMESH_HTTPS_PORT: String(https),
      HOME: folder,
      XDG_DATA_HOME: folder,
      XDG_CONFIG_HOME: folder,
    },
  );
}

export const startProxy = { nginx: startNginx, caddy: startCaddy };
