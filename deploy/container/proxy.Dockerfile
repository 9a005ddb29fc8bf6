# Caddy, run by a user without rights. The program's file capability goes: it needs none for ports above
# 1024, and could not be started without it where capabilities are dropped.
FROM caddy:2.11.4
RUN setcap -r /usr/bin/caddy && chown -R 10001:10001 /data /config
COPY deploy/proxy/Caddyfile /etc/caddy/Caddyfile
USER 10001:10001
EXPOSE 8080 8443
STOPSIGNAL SIGTERM
HEALTHCHECK --interval=10s --timeout=5s CMD ["wget", "-q", "-O", "/dev/null", "http://127.0.0.1:2019/config/"]
