// Toggles PB5 in the overflow of timer 0: every 256 * 64 cycles.
#include <avr/interrupt.h>
#include <avr/io.h>

ISR(TIMER0_OVF_vect)
{
	PINB = 1 << PB5;
}

int main(void)
{
	DDRB = 1 << PB5;
	TCCR0B = 1 << CS01 | 1 << CS00;
	TIMSK0 = 1 << TOIE0;
	sei();
	for (;;)
		;
}
