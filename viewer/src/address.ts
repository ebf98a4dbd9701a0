/** What is chosen, in the address after `#`, so that it can be kept and passed on: `#world=NAME&robot=NAME`. */

export interface Choice {
  world: string;
  robot: string;
}

export function readChoice(hash: string): Choice {
  const parameters = new URLSearchParams(hash.replace(/^#/, ""));
  return { world: parameters.get("world") ?? "", robot: parameters.get("robot") ?? "" };
}

export function writeChoice({ world, robot }: Choice): string {
  if (world === "") return "";
  const parameters = new URLSearchParams({ world });
  if (robot !== "") parameters.set("robot", robot);
  return `#${parameters}`;
}
