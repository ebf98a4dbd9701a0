/** What the page's address asks for: the page for people, or a film for the program. */
import "uplot/dist/uPlot.min.css";
import "./style/base.css";
import "./style/layout.css";
import "./style/panels.css";
import "./style/replay.css";
import "./style/cable.css";
import { filmWasAskedFor } from "./film/headless";

if (!filmWasAskedFor()) void import("./page");
