// A scale of notes, each 200 ms, with pauses of 50 ms, then one that lasts.
const int PIEZO = 8;
const unsigned NOTES[] = {31, 262, 440, 1000, 4000, 20000};

void setup() {
  for (unsigned i = 0; i < sizeof(NOTES) / sizeof(NOTES[0]); i++) {
    tone(PIEZO, NOTES[i], 200);
    delay(250);
  }
  tone(PIEZO, 523);
  delay(300);
  noTone(PIEZO);
}

void loop() {}
