// Two wheels hold their speeds: the left one at an L298N, the right one at a TB6612, each with an encoder of 40 edges a turn.
struct Wheel {
  uint8_t in1, in2, pwm;
  volatile unsigned long edges;
  unsigned long last;
  float integral, wanted;
};

Wheel left = {7, 8, 9, 0, 0, 0, 200};
Wheel right = {12, 13, 10, 0, 0, 0, -120};

void leftEdge() {
  left.edges++;
}

void rightEdge() {
  right.edges++;
}

void control(Wheel &wheel) {
  noInterrupts();
  unsigned long edges = wheel.edges;
  interrupts();
  // 20 ms.
  float speed = (edges - wheel.last) * 50.0;
  wheel.last = edges;
  float error = fabs(wheel.wanted) - speed;
  wheel.integral = constrain(wheel.integral + error * 0.02, 0.0, 250.0);
  int output = constrain(0.2 * error + 2.0 * wheel.integral, 0.0, 255.0);
  digitalWrite(wheel.in1, wheel.wanted >= 0);
  digitalWrite(wheel.in2, wheel.wanted < 0);
  analogWrite(wheel.pwm, output);
}

void setup() {
  Serial.begin(9600);
  const uint8_t directions[4] = {7, 8, 12, 13};
  for (uint8_t pin : directions) {
    pinMode(pin, OUTPUT);
  }
  attachInterrupt(digitalPinToInterrupt(2), leftEdge, CHANGE);
  attachInterrupt(digitalPinToInterrupt(3), rightEdge, CHANGE);
}

void loop() {
  static unsigned long next = 0;
  static uint8_t turns = 0;
  if ((long)(millis() - next) < 0) {
    return;
  }
  next += 20;
  control(left);
  control(right);
  if (++turns == 50) {
    turns = 0;
    Serial.print(left.edges);
    Serial.print(' ');
    Serial.println(right.edges);
  }
}
