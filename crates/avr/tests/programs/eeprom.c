// Increments a counter in the EEPROM, and reads a text that the EEPROM was delivered with.
#include <avr/eeprom.h>
#include <avr/io.h>

uint16_t EEMEM counter = 41;
char EEMEM text[4] = "abc";

int main(void)
{
	eeprom_update_word(&counter, eeprom_read_word(&counter) + 1);
	eeprom_busy_wait();
	GPIOR0 = eeprom_read_word(&counter);
	GPIOR1 = eeprom_read_byte((uint8_t *)&text[2]);
	PORTB = 1;
	for (;;)
		;
}
