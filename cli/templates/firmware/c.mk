# Builds {name}.hex. Debian and Ubuntu have the compiler: apt install gcc-avr avr-libc binutils-avr make
NAME = {name}
BAUDBOT ?= baudbot

$(NAME).hex: $(NAME).elf
	avr-objcopy -O ihex -R .eeprom $< $@

$(NAME).elf: $(NAME).c
	avr-gcc -mmcu=atmega328p -DF_CPU=16000000UL -std=gnu11 -Os -g -Wall -o $@ $<
	avr-size $@

# Lets the robot drive for a minute.
run: $(NAME).hex
	$(BAUDBOT) run robot.toml --seconds 60

# Shows it on a page, at the pace of the wall clock.
watch: $(NAME).hex
	$(BAUDBOT) serve robot.toml

clean:
	rm -f $(NAME).elf $(NAME).hex

.PHONY: run watch clean
