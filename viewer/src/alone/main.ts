/** The page that has the world in it: the viewer, a server in a worker, and brains. */
import "uplot/dist/uPlot.min.css";
import "../style/base.css";
import "../style/layout.css";
import "../style/panels.css";
import "../style/replay.css";
import "../style/cable.css";
import "../style/alone.css";
import { find } from "../dom";
import { setHost } from "../host";
import { Crew } from "./crew";
import { CrewSection } from "./crew_section";
import { parts as partsOfPage } from "./parts";
import { StartDialog } from "./start_dialog";
import { WorldHost } from "./world_host";

const parts = partsOfPage();
const host = new WorldHost(parts);
setHost(host);

void begin();

async function begin(): Promise<void> {
  const { connection, orders, store } = await import("../page");
  host.failed = (error) => store.note(`The world has stopped: ${error}. Reload the page.`, "error");
  const crew = new Crew(host, parts);
  const start = new StartDialog(host, crew, connection, orders);
  const section = new CrewSection(host, crew, store, () => start.show());
  find("worlds").querySelector(".scroll")?.prepend(section.element);
  find("page").append(start.element, section.dialog);
  await Promise.all([start.fill(), section.fill(host)]);
  // Who comes sees a robot that drives. Tests begin with nothing.
  if (!location.hash.includes("empty")) await start.demonstrate();
}
