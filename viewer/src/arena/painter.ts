/** Draws the arena: the ground from a picture that is kept as long as the view stays, and all that moves over it. */
import type { Belief } from "../gen/baudbot/v1/brain_link_pb";
import type { DescribeWorldResponse, GetCoverageResponse } from "../gen/baudbot/v1/observe_pb";
import { surface } from "../dom";
import { poseOf } from "../model/motion";
import { drawAxes, drawScaleBar } from "./axes";
import { drawBelief, drawBeliefMap } from "./belief";
import { Ground } from "./ground";
import { drawActuators, drawBlinking } from "./lamps";
import type { Theme } from "./palette";
import { drawRobots, drawTrails } from "./robots";
import { worldBounds, type Scene } from "./scene";
import { drawSenses } from "./senses";
import { drawGhost, drawHeld, drawThings } from "./things";

/** Beliefs of other robots that are drawn at once. */
const MOST_BELIEFS = 50;

export class Painter {
  private readonly kept = document.createElement("canvas");
  private keptKey = "";
  private keptMap: GetCoverageResponse | undefined;
  private ground: { of: DescribeWorldResponse; theme: Theme; ground: Ground } | undefined;

  /** One picture. */
  paint(scene: Scene): void {
    const { context, view, store, layers, poses } = scene;
    context.setLineDash([]);
    this.paintGround(scene);
    if (!store.description) return;
    drawBlinking(scene);
    const beliefs = shownBeliefs(scene);
    for (const [, belief] of beliefs) drawBeliefMap(scene, belief);
    drawThings(scene);
    if (layers.trails) drawTrails(scene);
    const pose = poses && poseOf(poses, store.robotIndex);
    if (layers.rays && pose) drawSenses(scene, pose);
    drawRobots(scene);
    drawActuators(scene);
    if (layers.ghost) drawGhost(scene);
    for (const [robot, belief] of beliefs) drawBelief(scene, robot, belief);
    drawHeld(scene);
    drawAxes(scene);
    if (view.width > 200) drawScaleBar(scene);
  }

  private paintGround(scene: Scene): void {
    const { context, view, store, theme, layers } = scene;
    if (!store.description) {
      context.fillStyle = theme.floor;
      context.fillRect(0, 0, view.width, view.height);
      return;
    }
    const ground = this.groundOf(scene, store.description);
    const { x_m, y_m, scale, width, height } = view;
    const key = [x_m, y_m, scale, width, height, window.devicePixelRatio, layers.fields].join(" ");
    const map = layers.coverage ? store.coverage : undefined;
    if (key !== this.keptKey || map !== this.keptMap) {
      ground.draw(surface(this.kept, width, height), view, layers.fields, map);
      this.keptKey = key;
      this.keptMap = map;
    }
    context.drawImage(this.kept, 0, 0, width, height);
  }

  private groundOf(scene: Scene, description: DescribeWorldResponse): Ground {
    const known = this.ground;
    if (known && known.of === description && known.theme === scene.theme) return known.ground;
    const ground = new Ground(description, scene.theme, worldBounds(scene.store));
    this.ground = { of: description, theme: scene.theme, ground };
    this.keptKey = "";
    return ground;
  }
}

/** The chosen robot's belief, or those of all; the chosen one's is drawn last. */
function shownBeliefs({ store, layers }: Scene): [number, Belief][] {
  if (!layers.belief) return [];
  const isChosen = ([robot]: [number, Belief]) => robot === store.robotIndex;
  const all = [...store.beliefs];
  const others = layers.allBeliefs ? all.filter((one) => !isChosen(one)).slice(0, MOST_BELIEFS) : [];
  return [...others, ...all.filter(isChosen)];
}
