// Timers and the ADC as other simulators have them, too: what each step leaves is pushed into a buffer in memory, and 0xA5 in
// GPIOR0 says that all is done.
#include <avr/interrupt.h>
#include <avr/io.h>

static volatile uint16_t results[64];
static volatile uint8_t count;

static void put(uint16_t result)
{
	results[count++] = result;
}

static void timer1(uint8_t control_a, uint8_t control_b, uint16_t top)
{
	// ICR1 can be written only while it is the top.
	TCCR1B = control_b & 0x18;
	TCCR1A = control_a;
	ICR1 = top;
	OCR1A = top / 2;
	OCR1B = top / 3;
	TIFR1 = 0x27;
	TCNT1 = 0;
	TCCR1B = control_b;
	for (uint8_t i = 0; i < 4; i++) {
		for (volatile uint8_t wait = 0; wait < 20; wait++)
			;
		put(TCNT1);
		put(TIFR1);
	}
	TCCR1B = 0;
}

int main(void)
{
	timer1(0, 1 << CS10, 0);
	timer1(0, 1 << WGM13 | 1 << WGM12 | 1 << CS10, 300);
	timer1(1 << WGM11, 1 << WGM13 | 1 << WGM12 | 1 << CS10, 199);
	timer1(1 << WGM11, 1 << WGM13 | 1 << CS10, 150);
	timer1(0, 1 << WGM13 | 1 << CS10, 150);
	ADMUX = 1 << REFS0;
	ADCSRA = 1 << ADEN | 4;
	TCCR1A = 0;
	TCCR1B = 1 << CS10;
	for (uint8_t i = 0; i < 3; i++) {
		uint16_t before = TCNT1;
		ADCSRA |= 1 << ADSC;
		while (ADCSRA & 1 << ADSC)
			;
		put(TCNT1 - before);
		put(ADC);
	}
	GPIOR0 = 0xA5;
	for (;;)
		;
}
