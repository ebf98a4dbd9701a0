// Conversions of the ADC, for comparison with another simulator. PB5 is toggled before a conversion is started, and PB4 by its
// interrupt. The results are in a buffer in memory, their number first. 0xA5 in GPIOR0 says that all is done.
#include <avr/interrupt.h>
#include <avr/io.h>

static volatile struct {
	uint16_t count;
	uint16_t results[100];
} found;

ISR(ADC_vect, ISR_NAKED)
{
	asm volatile("sbi %0, 4\n reti" : : "I"(_SFR_IO_ADDR(PINB)));
}

// Instructions of one cycle each, so that an interrupt does not wait for the end of a longer one.
__attribute__((noinline)) static void nops(void)
{
	asm volatile(".rept 1900\n nop\n .endr");
}

// Starts a conversion, and waits until its interrupt is over.
static void convert(uint8_t control, uint8_t multiplexer)
{
	ADMUX = multiplexer;
	PINB = 1 << PB5;
	ADCSRA = control;
	nops();
	nops();
	uint8_t low = ADCL;
	found.results[found.count++] = ADCH << 8 | low;
}

int main(void)
{
	DDRB = 1 << PB5 | 1 << PB4;
	sei();
	for (uint8_t clock = 1; clock <= 7; clock++) {
		uint8_t control = 1 << ADEN | 1 << ADIE | clock;
		ADCSRA = 0;
		// The first conversion, one against another reference, one adjusted to the left, the bandgap and ground.
		convert(control | 1 << ADSC, 1 << REFS0);
		convert(control | 1 << ADSC, 1 << REFS1 | 1 << REFS0 | 2);
		convert(control | 1 << ADSC, 1 << REFS0 | 1 << ADLAR | 5);
		convert(control | 1 << ADSC, 1 << REFS0 | 14);
		convert(control | 1 << ADSC, 15);
	}
	GPIOR0 = 0xA5;
	for (;;)
		;
}
