export type Route =
  | { view: "dives" }
  | { view: "dive"; id: string }
  | { view: "job"; id: string }
  | { view: "jobs" }
  | { view: "sensors" }
  | { view: "admin" }
  | { view: "sign_in" }
  | { view: "share" }
  | { view: "embed" }
  | { view: "not_found" };

// Returns the view that a path names.
export function route_of(path: string): Route {
  const parts = path.split("/").filter((part) => part !== "").map(decode);
  const [first, second, ...rest] = parts;
  if (rest.length > 0) return { view: "not_found" };
  if (first === undefined || (first === "dives" && second === undefined)) return { view: "dives" };
  if (first === "dives" && second) return { view: "dive", id: second };
  if (first === "jobs" && second) return { view: "job", id: second };
  if (second !== undefined) return { view: "not_found" };
  if (first === "jobs") return { view: "jobs" };
  if (first === "sensors") return { view: "sensors" };
  if (first === "admin") return { view: "admin" };
  if (first === "sign-in") return { view: "sign_in" };
  if (first === "share") return { view: "share" };
  if (first === "embed") return { view: "embed" };
  return { view: "not_found" };
}

function decode(part: string): string {
  try {
    return decodeURIComponent(part);
  } catch {
    return part;
  }
}

// Where the page is. The secret of a sign-in or share link is taken out of the address at once.
class Router {
  path = $state(window.location.pathname);
  query = $state.raw(new URLSearchParams(window.location.search));
  route = $derived(route_of(this.path));

  constructor() {
    window.addEventListener("popstate", () => this.#read());
    document.addEventListener("click", (event) => this.#follow(event));
  }

  go(address: string, replace = false): void {
    const target = new URL(address, window.location.href);
    if (replace) window.history.replaceState(null, "", target);
    else window.history.pushState(null, "", target);
    const moved = target.pathname !== this.path;
    this.#read();
    if (moved && !replace) window.scrollTo(0, 0);
  }

  // Changes one word of the query and keeps the rest of the address.
  set_query(name: string, value: string, replace = true): void {
    const target = new URL(window.location.href);
    if (value) target.searchParams.set(name, value);
    else target.searchParams.delete(name);
    this.go(target.href, replace);
  }

  // Returns the secret behind # and removes it from the address and the history.
  take_secret(): string {
    const secret = decode(window.location.hash.slice(1));
    if (secret) window.history.replaceState(null, "", window.location.pathname + window.location.search);
    return secret;
  }

  #read(): void {
    this.path = window.location.pathname;
    this.query = new URLSearchParams(window.location.search);
  }

  #follow(event: MouseEvent): void {
    if (event.defaultPrevented || event.button !== 0 || event.metaKey || event.ctrlKey || event.shiftKey) return;
    const link = (event.target as Element | null)?.closest?.("a");
    if (!link || link.target || link.hasAttribute("download") || link.origin !== window.location.origin) return;
    if (link.pathname.startsWith("/api/") || link.pathname.startsWith("/assets/")) return;
    if (link.hash && link.pathname === window.location.pathname) return;
    event.preventDefault();
    this.go(link.href);
  }
}

export const router = new Router();
