// What Print and String make of numbers.
void setup() {
  Serial.begin(115200);
  Serial.println(3.14159, 4);
  Serial.println(-0.005);
  Serial.println(1.0 / 0.0);
  Serial.println(sqrt(-1.0));
  Serial.println(5e9);
  Serial.println(255, BIN);
  Serial.println(-1L, HEX);
  Serial.println(4294967295UL);
  Serial.println(-2147483647L - 1);
  String text = String("v=") + 42 + ',' + String(2.5, 3) + ',' + true;
  text.replace("42", "-17");
  Serial.println(text);
  Serial.println(text.indexOf(','));
  Serial.println(text.substring(2).toInt());
  Serial.println(String("6.25").toFloat() * 4);
  char buffer[40];
  snprintf(buffer, sizeof buffer, "%05d|%-6s|%08lx|%c", -42, "ab", 0xBEEFUL, '!');
  Serial.println(buffer);
  dtostrf(-7.125, 9, 2, buffer);
  Serial.println(buffer);
  Serial.println(sin(1.0) * 1000.0, 3);
  Serial.println(pow(2.0, 0.5), 5);
  Serial.println(millis() < 1000);
}

void loop() {}
