// One instruction after another by avr8js, for comparison. The protocol is that of ../simavr/step.c.
//
//     node step.mjs FOLDER     FOLDER: where `npm install --prefix FOLDER avr8js@0.21.1` has put it
import { createRequire } from "node:module";
import { createInterface } from "node:readline";
import { join, resolve } from "node:path";

const require = createRequire(join(resolve(process.argv[2]), "package.json"));
const { CPU, avrInstruction } = require("avr8js");

const RAM = 0x100, RAM_END = 0x900, UPPER = 0x2000, FLASH = 0x4000;
const SHARED = [0x3e, 0x4a, 0x4b];
const program = new Uint16Array(FLASH);
const flash = new Uint8Array(program.buffer);
for (let i = 2 * UPPER; i < 2 * FLASH; i++) flash[i] = i * 29 + 7;
const pattern = new Uint8Array(RAM_END);
for (let i = RAM; i < RAM_END; i++) pattern[i] = i * 37 + 11;
const cpu = new CPU(program, RAM_END - RAM);
const hex = (value) => value.toString(16);

for await (const line of createInterface({ input: process.stdin })) {
  const fields = line.split(" ");
  const [w0, w1, w2, pc, sreg, sp] = fields.slice(0, 6).map((field) => parseInt(field, 16));
  program.set([w0, w1, w2], pc);
  cpu.data.set(pattern.subarray(RAM), RAM);
  for (const address of SHARED) cpu.data[address] = 0;
  for (let i = 0; i < 32; i++) cpu.data[i] = parseInt(fields[6].slice(2 * i, 2 * i + 2), 16);
  cpu.data[95] = sreg;
  cpu.dataView.setUint16(93, sp, true);
  cpu.pc = pc;
  const before = cpu.cycles;
  avrInstruction(cpu);
  const out = [cpu.cycles - before, cpu.pc & (FLASH - 1), cpu.data[95], cpu.dataView.getUint16(93, true)].map(hex);
  out.push(Array.from(cpu.data.subarray(0, 32), (byte) => hex(byte).padStart(2, "0")).join(""));
  for (const address of SHARED) if (cpu.data[address]) out.push(`${hex(address)}=${hex(cpu.data[address]).padStart(2, "0")}`);
  for (let i = RAM; i < RAM_END; i++) if (cpu.data[i] !== pattern[i]) out.push(`${hex(i)}=${hex(cpu.data[i]).padStart(2, "0")}`);
  console.log(out.join(" "));
  program.fill(0, pc, pc + 3);
}
