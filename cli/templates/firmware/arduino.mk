# Builds {name}.hex for an Arduino Uno. Debian and Ubuntu have all that it needs:
# apt install gcc-avr avr-libc binutils-avr arduino-core-avr make
NAME = {name}
BAUDBOT ?= baudbot
# The core's libraries that the sketch includes, of EEPROM SPI SoftwareSerial Wire. Other libraries go beside the sketch.
LIBRARIES =

ARDUINO ?= /usr/share/arduino/hardware/arduino/avr
FOLDERS = $(ARDUINO)/cores/arduino $(foreach l,$(LIBRARIES),$(ARDUINO)/libraries/$(l)/src $(ARDUINO)/libraries/$(l)/src/utility) .
SOURCES = $(foreach f,$(FOLDERS),$(wildcard $(f)/*.c $(f)/*.cpp $(f)/*.S))
OBJECTS = $(patsubst %,build/%.o,$(notdir $(SOURCES)) $(NAME).ino)
vpath %.c $(FOLDERS)
vpath %.cpp $(FOLDERS)
vpath %.S $(FOLDERS)

# As the core's platform.txt has them. Debian's avr-libc lacks DECIMAL_DIG, which the core needs.
OPTIONS = -mmcu=atmega328p -DF_CPU=16000000L -DARDUINO=10819 -DARDUINO_AVR_UNO -DARDUINO_ARCH_AVR -DDECIMAL_DIG=17 \
	-g -Os -w -ffunction-sections -fdata-sections -flto -I$(ARDUINO)/variants/standard $(addprefix -I,$(FOLDERS))
CPP = avr-g++ $(OPTIONS) -std=gnu++11 -fpermissive -fno-exceptions -fno-threadsafe-statics

$(NAME).hex: build/$(NAME).elf
	avr-objcopy -O ihex -R .eeprom $< $@

build/$(NAME).elf: $(OBJECTS)
	avr-gcc $(OPTIONS) -fuse-linker-plugin -Wl,--gc-sections -o $@ $^ -lm
	avr-size $@

build/%.ino.o: %.ino | build
	$(CPP) -x c++ -include Arduino.h -c -o $@ $<

build/%.cpp.o: %.cpp | build
	$(CPP) -c -o $@ $<

build/%.c.o: %.c | build
	avr-gcc $(OPTIONS) -std=gnu11 -c -o $@ $<

build/%.S.o: %.S | build
	avr-gcc $(OPTIONS) -x assembler-with-cpp -c -o $@ $<

build:
	@test -d $(ARDUINO) || { echo "$(ARDUINO) is not there: apt install arduino-core-avr, or set ARDUINO=..."; exit 1; }
	mkdir -p build

# Lets the robot drive for a minute.
run: $(NAME).hex
	$(BAUDBOT) run robot.toml --seconds 60

# Shows it on a page, at the pace of the wall clock.
watch: $(NAME).hex
	$(BAUDBOT) serve robot.toml

clean:
	rm -rf build $(NAME).hex

.PHONY: run watch clean
