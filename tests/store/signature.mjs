// A proxy that checks the signatures of requests (AWS Signature Version 4), which s3rver does not: from what arrives,
// as the store of a stranger would.
import { createHash, createHmac } from "node:crypto";
import { createServer, request } from "node:http";

const hmac = (key, text) => createHmac("sha256", key).update(text).digest();

/** Whether a request is signed with this secret. Its path must be percent-encoded, and it has no query. */
function isSigned(from, secret) {
  const parts = /^AWS4-HMAC-SHA256 Credential=[^/]+\/(\d+)\/([^/]+)\/s3\/aws4_request, ?SignedHeaders=([^,]+), ?Signature=(\w+)$/
    .exec(from.headers.authorization ?? "");
  if (!parts || from.url.includes("?")) return false;
  const [, day, region, names, signature] = parts;
  const headers = names.split(";");
  // Everything that begins so has to be signed, and the host.
  if (!headers.includes("host") || headers.some((name) => !(name in from.headers))) return false;
  if (Object.keys(from.headers).some((name) => name.startsWith("x-amz-") && !headers.includes(name))) return false;
  const canonical = [from.method, from.url, "", ...headers.map((name) => `${name}:${(from.headers[name] ?? "").trim()}`), "",
                     names, from.headers["x-amz-content-sha256"]].join("\n");
  const text = ["AWS4-HMAC-SHA256", from.headers["x-amz-date"], `${day}/${region}/s3/aws4_request`,
                createHash("sha256").update(canonical).digest("hex")].join("\n");
  const key = ["aws4_request"].reduce(hmac, hmac(hmac(hmac(`AWS4${secret}`, day), region), "s3"));
  return hmac(key, text).toString("hex") === signature;
}

/** Passes requests that are signed with `secret` on to a port of this machine. Resolves to the server. */
export function checkSignatures(port, secret) {
  const server = createServer((from, to) => {
    if (!isSigned(from, secret)) {
      from.resume();
      to.writeHead(403, { "Content-Type": "application/xml" }).end("<Error><Code>SignatureDoesNotMatch</Code></Error>");
      return;
    }
    from.pipe(request({ port, host: "127.0.0.1", method: from.method, path: from.url, headers: from.headers },
      (answer) => answer.pipe(to.writeHead(answer.statusCode, answer.headers))));
  });
  return new Promise((resolve) => server.listen(0, "127.0.0.1", () => resolve(server)));
}
