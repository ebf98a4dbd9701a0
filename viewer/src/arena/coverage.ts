/** Which cells of the floor are covered and sensed: a picture of one pixel a cell, made again when another map has come. */
import type { GetCoverageResponse } from "../gen/baudbot/v1/observe_pb";
import { fillRuns } from "../model/coverage";
import { rgb, type Theme, type Tint } from "./palette";
import { useMetres, type View } from "./view";

/** Cells along a side of a canvas: browsers draw none that is much longer. */
const TILE = 8192;

interface Tile {
  canvas: HTMLCanvasElement;
  column: number;
  row: number;
}

export class CoveragePicture {
  private map: GetCoverageResponse | undefined;
  private pixels = new ImageData(1, 1);
  private tiles: Tile[] = [];

  constructor(private readonly theme: Theme) {}

  draw(context: CanvasRenderingContext2D, view: View, map: GetCoverageResponse): void {
    if (map !== this.map) this.paint(map);
    context.save();
    // Here y goes up, as the rows of cells do.
    useMetres(context, view);
    context.translate(map.xM, map.yM);
    context.scale(map.cellM, map.cellM);
    // What is larger than a pixel has sharp edges.
    context.imageSmoothingEnabled = map.cellM * view.scale < 1;
    for (const { canvas, column, row } of this.tiles) context.drawImage(canvas, column, row);
    context.restore();
  }

  private paint(map: GetCoverageResponse): void {
    const { columns, rows, sensed, covered } = map;
    const { width, height } = this.pixels;
    if (width !== columns || height !== rows) {
      this.pixels = new ImageData(columns, rows);
      this.tiles = tilesOf(columns, rows);
    }
    const cells = new Uint32Array(this.pixels.data.buffer);
    cells.fill(0);
    fillRuns(cells, sensed, word(this.theme.sensed));
    fillRuns(cells, covered, word(this.theme.covered));
    for (const { canvas, column, row } of this.tiles) canvas.getContext("2d")?.putImageData(this.pixels, -column, -row);
    this.map = map;
  }
}

function tilesOf(columns: number, rows: number): Tile[] {
  const tiles: Tile[] = [];
  for (let row = 0; row < rows; row += TILE)
    for (let column = 0; column < columns; column += TILE) {
      const canvas = document.createElement("canvas");
      canvas.width = Math.min(TILE, columns - column);
      canvas.height = Math.min(TILE, rows - row);
      tiles.push({ canvas, column, row });
    }
  return tiles;
}

/** A pixel as it lies in memory. */
function word({ hue, opacity }: Tint): number {
  return new Uint32Array(Uint8Array.of(...rgb(hue), Math.round(255 * opacity)).buffer)[0] ?? 0;
}
