// Asks a machine three times for a line, with termios and select. It prints when the answers have come, in ns since its start.
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/select.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

static long long now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return time.tv_sec * 1000000000LL + time.tv_nsec;
}

int main(int count, char **words) {
    int times = count > 2 ? atoi(words[2]) : 3;
    speed_t speed = B9600;
    if (count > 3 && !strcmp(words[3], "1200")) speed = B1200;
    if (count > 3 && !strcmp(words[3], "115200")) speed = B115200;
    int port = open(words[1], O_RDWR | O_NOCTTY);
    if (port < 0 || !isatty(port)) return perror("open"), 1;
    struct termios settings;
    tcgetattr(port, &settings);
    cfmakeraw(&settings);
    cfsetspeed(&settings, speed);
    tcsetattr(port, TCSANOW, &settings);
    for (int i = 0; i < times; i++) {
        long long start = now();
        if (write(port, "HELLO\n" + 1, 5) != 5) return 2;
        int length = 0;
        char line[64];
        do {
            fd_set set;
            FD_ZERO(&set);
            FD_SET(port, &set);
            struct timeval timeout = {1, 0};
            if (select(port + 1, &set, NULL, NULL, &timeout) != 1) return 3;
            length += read(port, line + length, sizeof line - length);
        } while (line[length - 1] != '\n');
        printf("%lld %.*s", now() - start, length, line);
        fflush(stdout);
        usleep(100000);
    }
    return 0;
}
