import { router } from "../app/router.svelte";

// Whether this visit came by a share link: the page then shows the one result and no navigation, and
// asks for nothing that the link does not open.
class Sharing {
  active = $state(sessionStorage.getItem("divemesh.shared") === "1");

  begin(): void {
    this.active = true;
    sessionStorage.setItem("divemesh.shared", "1");
  }

  end(): void {
    this.active = false;
    sessionStorage.removeItem("divemesh.shared");
  }

  open(job_id: string): void {
    router.go(`/jobs/${encodeURIComponent(job_id)}?view=model`, true);
  }
}

export const sharing = new Sharing();
