// Sends back each character plus one, by interrupts; 'F' or 'P' or 'O' instead if it came with an error.
// BAUD_UBRR and BAUD_U2X are given by the compiler's options.
#include <avr/interrupt.h>
#include <avr/io.h>

ISR(USART_RX_vect)
{
	uint8_t status = UCSR0A;
	uint8_t byte = UDR0;
	if (status & 1 << FE0)
		UDR0 = 'F';
	else if (status & 1 << UPE0)
		UDR0 = 'P';
	else if (status & 1 << DOR0)
		UDR0 = 'O';
	else
		UDR0 = byte + 1;
}

int main(void)
{
	UBRR0 = BAUD_UBRR;
	UCSR0A = BAUD_U2X << U2X0;
	UCSR0B = 1 << RXEN0 | 1 << TXEN0 | 1 << RXCIE0;
	sei();
	for (;;)
		;
}
