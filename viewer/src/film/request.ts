/** A film that the program asks for, in the page's address: `?film=gif&world=NAME&from_s=0&to_s=10&post=/film`. */
import type { Format } from "./film";
import type { FilmWish } from "./plan";

export interface FilmRequest extends FilmWish {
  format: Format;
  world: string;
  robot: string;
  width: number;
  dark: boolean;
  /** The path on this server to which the film is posted. */
  post: string;
}

const POST = "/film";

/** What the address asks for; undefined if it asks for no film. What is wrong with it is thrown, in words. */
export function readFilmRequest(search: string, origin: string): FilmRequest | undefined {
  const query = new URLSearchParams(search);
  const format = query.get("film");
  if (format === null) return undefined;
  if (format !== "gif" && format !== "webm") throw new Error("film: must be gif or webm");
  const width = number(query, "width") ?? 800;
  if (!(width >= 64 && width <= 3840)) throw new Error("width: must be 64 to 3840");
  return {
    format,
    world: query.get("world") ?? "",
    robot: query.get("robot") ?? "",
    from_s: number(query, "from_s"),
    to_s: number(query, "to_s"),
    speed: number(query, "speed") ?? 1,
    fps: number(query, "fps") ?? 20,
    width,
    dark: query.get("theme") === "dark",
    post: ownPath(query.get("post") ?? POST, origin),
  };
}

/** Where it is said that there is no film. */
export function failurePath(search: string, origin: string): string {
  try {
    return `${ownPath(new URLSearchParams(search).get("post") ?? POST, origin)}?failed=1`;
  } catch {
    return `${POST}?failed=1`;
  }
}

/** Nothing is sent to another server. */
function ownPath(path: string, origin: string): string {
  const url = new URL(path, origin);
  if (!path.startsWith("/") || url.origin !== origin) throw new Error("post: must be a path on this server");
  return url.pathname;
}

function number(query: URLSearchParams, name: string): number | undefined {
  const text = query.get(name);
  if (text === null || text === "") return undefined;
  const value = Number(text);
  if (!Number.isFinite(value)) throw new Error(`${name}: must be a number`);
  return value;
}
