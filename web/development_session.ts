import type { Plugin } from "vite";

// Answers the requests about the session as the server does, for development with a token from the
// environment: every visitor is signed in.
export function development_session(token: string): Plugin {
  const session = { csrf_token: "development", name: "development", scopes: ["admin"], project: "default", expires_at: 0 };
  return {
    name: "development-session",
    configureServer(server) {
      if (!token) return;
      server.middlewares.use("/api/v1/session", (request, response) => {
        response.setHeader("Content-Type", "application/json");
        response.statusCode = request.method === "DELETE" ? 204 : 200;
        response.end(request.method === "DELETE" ? undefined : JSON.stringify(session));
      });
    },
  };
}
