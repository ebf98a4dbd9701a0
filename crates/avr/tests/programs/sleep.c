// Sleeps in power-down until a pin of port D changes, and toggles PB0 after each time.
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>

EMPTY_INTERRUPT(PCINT2_vect)

int main(void)
{
	DDRB = 1;
	PORTD = 1 << PD7;
	PCMSK2 = 1 << PCINT23;
	PCICR = 1 << PCIE2;
	set_sleep_mode(SLEEP_MODE_PWR_DOWN);
	sei();
	for (;;) {
		sleep_mode();
		PINB = 1;
	}
}
