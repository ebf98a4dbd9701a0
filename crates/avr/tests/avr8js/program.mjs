// Runs an Intel HEX file on avr8js until GPIOR0 is 0xA5. The first line that it prints is the static memory from 0x100 on, as
// hexadecimal digits. Each further line is an edge at an output of the ports B or D: the port, the bit, the level, the cycle.
//
//     node program.mjs FOLDER FILE     FOLDER: where `npm install --prefix FOLDER avr8js@0.21.1` has put it
import { createRequire } from "node:module";
import { readFileSync } from "node:fs";
import { join, resolve } from "node:path";

const require = createRequire(join(resolve(process.argv[2]), "package.json"));
const js = require("avr8js");

const program = new Uint16Array(0x4000).fill(0xffff);
const flash = new Uint8Array(program.buffer);
for (const line of readFileSync(process.argv[3], "ascii").split("\n")) {
  if (line.slice(7, 9) !== "00") continue;
  const [count, address] = [parseInt(line.slice(1, 3), 16), parseInt(line.slice(3, 7), 16)];
  for (let i = 0; i < count; i++) flash[address + i] = parseInt(line.slice(9 + 2 * i, 11 + 2 * i), 16);
}
const cpu = new js.CPU(program, 0x800);
const edges = [];
for (const [name, config] of [["B", js.portBConfig], ["D", js.portDConfig]]) {
  new js.AVRIOPort(cpu, config).addListener((value, before) => {
    for (let bit = 0; bit < 8; bit++)
      if (((value ^ before) >> bit) & 1) edges.push(`${name} ${bit} ${(value >> bit) & 1} ${cpu.cycles}`);
  });
}
for (const config of [js.timer0Config, js.timer1Config, js.timer2Config]) new js.AVRTimer(cpu, config);
const adc = new js.AVRADC(cpu, js.adcConfig);
adc.channelValues.fill(2.5);
let steps = 0;
while (cpu.data[0x3e] !== 0xa5 && steps++ < 20_000_000) {
  js.avrInstruction(cpu);
  cpu.tick();
}
console.log(Buffer.from(cpu.data.subarray(0x100, 0x900)).toString("hex"));
for (const edge of edges) console.log(edge);
