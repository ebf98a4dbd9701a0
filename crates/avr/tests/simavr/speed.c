// Runs an Intel HEX file on simavr for some simulated seconds at 16 MHz, and prints the simulated megahertz.
#include <simavr/sim_avr.h>
#include <simavr/sim_hex.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

int main(int argc, char **argv)
{
	if (argc != 3)
		return 2;
	avr_t *avr = avr_make_mcu_by_name("atmega328p");
	uint32_t size, start;
	uint8_t *code = read_ihex_file(argv[1], &size, &start);
	if (!avr || !code)
		return 1;
	avr_init(avr);
	avr->frequency = 16000000;
	avr->log = 0;
	memcpy(avr->flash + start, code, size);
	avr->pc = start;
	avr->codeend = avr->flashend;
	avr_cycle_count_t end = 16000000ull * atoi(argv[2]);
	struct timespec begun, ended;
	clock_gettime(CLOCK_MONOTONIC, &begun);
	while (avr->cycle < end)
		avr_run(avr);
	clock_gettime(CLOCK_MONOTONIC, &ended);
	double seconds = ended.tv_sec - begun.tv_sec + 1e-9 * (ended.tv_nsec - begun.tv_nsec);
	printf("%f\n", avr->cycle / seconds / 1e6);
	return 0;
}
