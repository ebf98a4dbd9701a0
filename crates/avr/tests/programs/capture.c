// Measures the time between rising edges at ICP1 with timer 1, with the noise canceller, and leaves it in GPIOR1 and 2.
#include <avr/interrupt.h>
#include <avr/io.h>

ISR(TIMER1_CAPT_vect)
{
	static uint16_t last;
	uint16_t now = ICR1;
	uint16_t period = now - last;
	last = now;
	GPIOR1 = period;
	GPIOR2 = period >> 8;
	GPIOR0++;
}

int main(void)
{
	TCCR1B = 1 << ICNC1 | 1 << ICES1 | 1 << CS10;
	TIMSK1 = 1 << ICIE1;
	sei();
	for (;;)
		;
}
