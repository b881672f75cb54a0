// The served bench as functions. Paths are relative, so that a proxy may show the page under a sub-path.
export const lease = { key: sessionStorage.getItem("lease") };

export class Refused extends Error {
  constructor(status, detail) { super(detail); this.status = status; }
}

export async function ask(method, path, body) {
  const headers = {};
  if (lease.key) headers["X-Lease"] = lease.key;
  if (body !== undefined) headers["Content-Type"] = "application/json";
  const answer = await fetch(path, { method, headers, body: body === undefined ? undefined : JSON.stringify(body) });
  if (answer.status === 204) return null;
  if (!answer.ok) {
    let detail = `the server answers ${answer.status}`;
    try {
      const said = (await answer.json()).detail;
      detail = typeof said === "string" ? said : said.map(one => `${one.loc.slice(1).join(".")}: ${one.msg}`).join("; ");
    } catch { /* no JSON: a proxy's own page */ }
    throw new Refused(answer.status, detail);
  }
  return answer.json();
}

export async function takeLease() {
  lease.key = (await ask("POST", "api/lease")).lease;
  sessionStorage.setItem("lease", lease.key);
}
