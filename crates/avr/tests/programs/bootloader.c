// Writes a small application into page 0 and starts it: it sets GPIOR0 to 0x42 and stops. Linked to 0x7000, with BOOTRST.
#include <avr/boot.h>
#include <avr/io.h>

int main(void)
{
	// ldi r16, 0x42; out GPIOR0, r16; rjmp .-2
	static const uint16_t application[] = {0xE402, 0xBB0E, 0xCFFF};
	boot_page_erase_safe(0);
	for (uint8_t at = 0; at < 3; at++)
		boot_page_fill_safe(2 * at, application[at]);
	boot_page_write_safe(0);
	boot_rww_enable_safe();
	GPIOR1 = boot_signature_byte_get(0);
	asm volatile("jmp 0");
	for (;;)
		;
}
