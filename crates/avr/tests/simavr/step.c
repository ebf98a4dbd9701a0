// One instruction after another by simavr, for comparison.
//
// A line of input:  w0 w1 w2 pc sreg sp registers
// A line of output: cycles pc sreg sp registers [address=byte]...
// All numbers are hexadecimal, the 32 registers one number of 64 digits, pc a word address.
// Before each instruction the static memory holds its pattern, the upper half of the flash its own, and the lower zeros.
#include <simavr/sim_avr.h>
#include <simavr/sim_core.h>
#include <stdio.h>
#include <string.h>

enum { RAM = 0x100, RAM_END = 0x900, UPPER = 0x4000, FLASH = 0x8000 };

static unsigned char pattern[RAM_END];
static const int shared[] = {0x3E, 0x4A, 0x4B};

int main(void)
{
	setvbuf(stdout, NULL, _IOLBF, 1 << 12);
	avr_t *avr = avr_make_mcu_by_name("atmega328p");
	if (!avr)
		return 1;
	avr_init(avr);
	avr->log = 0;
	for (int i = 0; i < RAM_END; i++)
		pattern[i] = i < RAM ? 0 : i * 37 + 11;
	memset(avr->flash, 0, FLASH);
	for (int i = UPPER; i < FLASH; i++)
		avr->flash[i] = i * 29 + 7;
	unsigned w[3], pc, sreg, sp;
	char digits[65];
	while (scanf("%x %x %x %x %x %x %64s", w, w + 1, w + 2, &pc, &sreg, &sp, digits) == 7) {
		memcpy(avr->data + RAM, pattern + RAM, RAM_END - RAM);
		for (int i = 0; i < 3; i++)
			avr->data[shared[i]] = 0;
		for (int i = 0; i < 3; i++) {
			avr->flash[2 * pc + 2 * i] = w[i];
			avr->flash[2 * pc + 2 * i + 1] = w[i] >> 8;
		}
		for (int i = 0; i < 32; i++) {
			unsigned byte;
			sscanf(digits + 2 * i, "%2x", &byte);
			avr->data[i] = byte;
		}
		for (int i = 0; i < 8; i++)
			avr->sreg[i] = sreg >> i & 1;
		avr->data[R_SPL] = sp;
		avr->data[R_SPH] = sp >> 8;
		avr->pc = 2 * pc;
		avr->state = cpu_Running;
		avr->interrupt_state = 0;
		avr_cycle_count_t before = avr->cycle;
		avr_flashaddr_t next = avr_run_one(avr);
		unsigned after = 0;
		for (int i = 0; i < 8; i++)
			after |= (unsigned)avr->sreg[i] << i;
		printf("%x %x %x %x ", (unsigned)(avr->cycle - before), next / 2, after,
		       avr->data[R_SPL] | avr->data[R_SPH] << 8);
		for (int i = 0; i < 32; i++)
			printf("%02x", avr->data[i]);
		for (int i = 0; i < 3; i++)
			if (avr->data[shared[i]])
				printf(" %x=%02x", shared[i], avr->data[shared[i]]);
		for (int i = RAM; i < RAM_END; i++)
			if (avr->data[i] != pattern[i])
				printf(" %x=%02x", i, avr->data[i]);
		putchar('\n');
		for (int i = 0; i < 6; i++)
			avr->flash[2 * pc + i] = 0;
	}
	return 0;
}
