// Motors: fast PWM of timer 0 on OC0A and OC0B. A servo: timer 1, 1.5 ms in 20 ms on OC1A. A tone of 440 Hz: timer 2, OC2B.
#include <avr/io.h>

int main(void)
{
	DDRD = 1 << PD6 | 1 << PD5 | 1 << PD3;
	DDRB = 1 << PB1;
	OCR0A = 63;
	OCR0B = 191;
	TCCR0A = 1 << COM0A1 | 1 << COM0B1 | 1 << WGM01 | 1 << WGM00;
	TCCR0B = 1 << CS01;
	// ICR1 can be written only while it is the top.
	TCCR1A = 1 << COM1A1 | 1 << WGM11;
	TCCR1B = 1 << WGM13 | 1 << WGM12 | 1 << CS11;
	ICR1 = 39999;
	OCR1A = 2999;
	OCR2A = 141;
	TCCR2A = 1 << COM2B0 | 1 << WGM21;
	TCCR2B = 1 << CS22 | 1 << CS20;
	for (;;)
		;
}
