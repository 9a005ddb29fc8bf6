# An S3 store for one machine: the Versity gateway over a folder, run by a user without rights. Each folder
# in /data is a bucket, so `dives` is there from the first start.
FROM versity/versitygw:v1.8.0
RUN mkdir -p /data/dives && chown -R 10001:10001 /data
COPY --chmod=0755 deploy/container/s3_entrypoint.sh /usr/local/bin/s3-entrypoint
USER 10001:10001
VOLUME /data
EXPOSE 7070
STOPSIGNAL SIGTERM
HEALTHCHECK --interval=10s --timeout=5s CMD ["wget", "-q", "-O", "/dev/null", "http://127.0.0.1:7070/health"]
ENTRYPOINT ["s3-entrypoint"]
CMD ["--port", ":7070", "--region", "us-east-1", "--health", "/health", "--quiet", "posix", "/data"]
