/* Asks a Khepera for its sensors as programs in C do: termios, select, read. Prints when each answer was whole. Argument: the port. */
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/select.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

static long long now_ns(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * 1000000000LL + now.tv_nsec;
}

int main(int count, char **words) {
  struct termios port = {0};
  int file = open(words[count - 1], O_RDWR | O_NOCTTY);
  if (file < 0 || !isatty(file) || tcgetattr(file, &port)) return 1;
  cfmakeraw(&port);
  port.c_cflag |= CLOCAL | CREAD | CSTOPB;
  cfsetspeed(&port, B9600);
  if (tcsetattr(file, TCSANOW, &port)) return 2;
  for (int asked = 0; asked < 5; asked++) {
    long long begun = now_ns();
    int answered = 0;
    char last = 0;
    if (write(file, "N\r", 2) != 2) return 3;
    while (last != '\n') {
      fd_set files;
      struct timeval patience = {1, 0};
      FD_ZERO(&files);
      FD_SET(file, &files);
      if (select(file + 1, &files, NULL, NULL, &patience) != 1 || read(file, &last, 1) != 1) return 4;
      answered++;
    }
    printf("%d %lld\n", answered, now_ns() - begun);
    nanosleep(&(struct timespec){0, 20000000}, NULL);
  }
  return 0;
}
