// Work for the processor: a checksum over a sieve, again and again; the result goes to GPIOR1 and 2. A tick of timer 0 counts
// in GPIOR0 meanwhile.
#include <avr/interrupt.h>
#include <avr/io.h>
#include <string.h>

static uint8_t composite[1024];

ISR(TIMER0_COMPA_vect)
{
	GPIOR0++;
}

int main(void)
{
	OCR0A = 249;
	TCCR0A = 1 << WGM01;
	TCCR0B = 1 << CS01 | 1 << CS00;
	TIMSK0 = 1 << OCIE0A;
	sei();
	for (;;) {
		memset(composite, 0, sizeof composite);
		uint16_t sum = 0;
		for (uint16_t i = 2; i < sizeof composite; i++) {
			if (composite[i])
				continue;
			sum = sum * 31 + i;
			for (uint16_t j = 2 * i; j < sizeof composite; j += i)
				composite[j] = 1;
		}
		GPIOR1 = sum;
		GPIOR2 = sum >> 8;
	}
}
