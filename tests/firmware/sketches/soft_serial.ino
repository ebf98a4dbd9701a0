// Characters that come in at pin 10 go out at pin 11, one up, and are reported over the USART.
#include <SoftwareSerial.h>

SoftwareSerial port(10, 11);

void setup() {
  Serial.begin(115200);
  port.begin(9600);
  port.print("hello");
}

void loop() {
  if (port.available()) {
    int got = port.read();
    Serial.write(got);
    port.write(got + 1);
  }
}
