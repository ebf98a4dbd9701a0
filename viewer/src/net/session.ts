/**
 * The page's session. A script cannot show a token when it opens a socket, so the token is exchanged once for a cookie, which no script
 * can read. The link that the server gives its user ends with the token; a browser sends what is behind `#` to nobody.
 */

/** Takes the token out of the page's address, where it is not to stay. */
export function takeToken(): string {
  const parameters = new URLSearchParams(location.hash.replace(/^#/, ""));
  const token = parameters.get("token") ?? "";
  if (token !== "") {
    parameters.delete("token");
    const rest = parameters.toString();
    history.replaceState(null, "", rest === "" ? location.pathname : `#${rest}`);
  }
  return token;
}

/** Shows the token. Returns why it is not taken, or nothing. */
export async function showToken(token: string): Promise<string> {
  // A header has no room for other characters, and a token has none of them.
  if (!/^[\x21-\x7e]+$/.test(token)) return "a token has only letters, digits, - and _";
  try {
    const response = await fetch("/session", { method: "POST", headers: { authorization: `Bearer ${token}` } });
    return response.ok ? "" : (await response.text()).trim();
  } catch {
    return "the server does not answer";
  }
}

/** Whether the server wants a token that it has not been shown, as far as it answers at all. */
export async function wantsToken(): Promise<boolean> {
  try {
    return (await fetch("/session")).status === 401;
  } catch {
    return false;
  }
}
