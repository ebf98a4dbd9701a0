// Reads ADC0 to ADC5 one after another against AVCC and sends each result: high byte, low byte. 38400 baud at 16 MHz.
#include <avr/io.h>

static void send(uint8_t byte)
{
	while (!(UCSR0A & 1 << UDRE0))
		;
	UDR0 = byte;
}

int main(void)
{
	UBRR0 = 25;
	UCSR0B = 1 << TXEN0;
	ADCSRA = 1 << ADEN | 7;
	for (uint8_t channel = 0;; channel = channel == 5 ? 0 : channel + 1) {
		ADMUX = 1 << REFS0 | channel;
		ADCSRA |= 1 << ADSC;
		while (ADCSRA & 1 << ADSC)
			;
		uint16_t result = ADC;
		send(result >> 8);
		send(result);
	}
}
