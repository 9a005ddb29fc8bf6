// Exchanges the secret behind the # for a session and lists what the sharing link opens. All addresses are relative:
// a proxy may have put a prefix before them.
"use strict";

async function ask(path, options) {
  const response = await fetch(path, options);
  if (response.ok) return response.json();
  const problem = await response.json().catch(() => ({}));
  throw new Error(problem.detail ?? `the server answered ${response.status}`);
}

function add_file(job, artifact) {
  const link = document.createElement("a");
  link.textContent = artifact.name;
  link.href = `${job}/artifacts/${artifact.name.split("/").map(encodeURIComponent).join("/")}`;
  const item = document.createElement("li");
  item.append(link, ` (${(artifact.size_bytes / 1e6).toFixed(1)} MB)`);
  document.getElementById("files").append(item);
}

async function open_link() {
  const secret = location.hash.slice(1);
  history.replaceState(null, "", location.pathname); // the secret stays neither in the address nor in the history
  const begin = { method: "POST", headers: { Authorization: `Bearer ${secret}` } };
  const session = await ask("api/v1/session", secret ? begin : undefined);
  if (!session.shared_job) throw new Error("this address is not a sharing link: ask for a new one");
  const job = `api/v1/jobs/${encodeURIComponent(session.shared_job)}`;
  const dive = await ask(`api/v1/dives/${encodeURIComponent(session.shared_dive)}`);
  document.title = document.getElementById("title").textContent = dive.name;
  const { items } = await ask(`${job}/artifacts`);
  const is_folder = ({ name }) => name.includes("/");
  for (const artifact of items.filter((each) => !is_folder(each))) add_file(job, artifact);
  const all = document.createElement("a");
  all.textContent = "all files as one archive";
  all.href = `${job}/artifacts.zip`;
  document.getElementById("state").replaceChildren("Read-only: ", all);
}

open_link().catch((error) => {
  document.getElementById("state").textContent = `This link opens nothing: ${error.message}`;
});
