// Runs an Intel HEX file on avr8js until GPIOR0 is 0xA5, and prints the static memory from 0x100 on, as hexadecimal digits.
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
const cpu = new js.CPU(program);
for (const config of [js.timer0Config, js.timer1Config, js.timer2Config]) new js.AVRTimer(cpu, config);
const adc = new js.AVRADC(cpu, js.adcConfig);
adc.channelValues.fill(2.5);
let steps = 0;
while (cpu.data[0x3e] !== 0xa5 && steps++ < 10_000_000) {
  js.avrInstruction(cpu);
  cpu.tick();
}
console.log(Buffer.from(cpu.data.subarray(0x100, 0x100 + 1 + 2 * cpu.data[0x100])).toString("hex"));
