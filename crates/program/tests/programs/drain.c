// Times of tcdrain, of a write that fills the queue, of a break, and of TCSADRAIN; and the lines of the modem.
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

static long long start;

static void tell(const char *name) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    long long now = time.tv_sec * 1000000000LL + time.tv_nsec;
    printf("%s %lld\n", name, now - start);
    fflush(stdout);
    start = now;
}

int main(int count, char **words) {
    static char bytes[6096];
    int port = open(words[1], O_RDWR | O_NOCTTY), number;
    struct termios settings;
    tcgetattr(port, &settings);
    cfmakeraw(&settings);
    cfsetspeed(&settings, B115200);
    tcsetattr(port, TCSANOW, &settings);
    tell("start");
    start += 0;
    write(port, bytes, 100);
    tell("write");
    ioctl(port, TIOCOUTQ, &number);
    printf("unsent %d\n", number);
    tcdrain(port);
    tell("drain");
    write(port, bytes, sizeof bytes);
    tell("full");
    cfsetspeed(&settings, B9600);
    tcsetattr(port, TCSADRAIN, &settings);
    tell("settings");
    tcsendbreak(port, 0);
    tell("break");
    ioctl(port, TIOCMGET, &number);
    printf("lines %x\n", number & (TIOCM_DTR | TIOCM_RTS | TIOCM_CTS | TIOCM_DSR));
    number = TIOCM_DTR;
    ioctl(port, TIOCMBIC, &number);
    write(port, bytes, 100);
    tcflush(port, TCOFLUSH);
    tcdrain(port);
    tell("flush");
    return 0;
}
