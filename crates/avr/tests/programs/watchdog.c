// Counts its resets in memory that is not cleared, and waits for the watchdog to bite after 16 ms.
#include <avr/io.h>
#include <avr/wdt.h>

uint8_t resets __attribute__((section(".noinit")));

int main(void)
{
	uint8_t cause = MCUSR;
	MCUSR = 0;
	wdt_disable();
	resets = cause & 1 << PORF ? 0 : resets + 1;
	GPIOR0 = cause;
	GPIOR1 = resets;
	wdt_enable(WDTO_15MS);
	for (;;)
		;
}
