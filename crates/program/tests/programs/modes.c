// Reads with each kind of VMIN and VTIME. Prints what a read has given, and after how many ns.
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

static int port;
static struct termios settings;

static long long now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return time.tv_sec * 1000000000LL + time.tv_nsec;
}

static void mode(int least, int tenths) {
    usleep(100000);
    settings.c_cc[VMIN] = least;
    settings.c_cc[VTIME] = tenths;
    tcsetattr(port, TCSAFLUSH, &settings);
}

static void look(const char *name, int room) {
    char bytes[64];
    long long start = now();
    int count = read(port, bytes, room);
    if (count < 0) printf("%s: %s after %lld\n", name, strerror(errno), now() - start);
    else printf("%s: %.*s after %lld\n", name, count, bytes, now() - start);
    fflush(stdout);
}

int main(int count, char **words) {
    port = open(words[1], O_RDWR | O_NOCTTY);
    tcgetattr(port, &settings);
    cfmakeraw(&settings);
    mode(0, 0);
    look("0/0", 9);
    mode(0, 3);
    look("0/3 silent", 9);
    write(port, "ab", 2);
    look("0/3", 9);
    mode(3, 0);
    write(port, "abcd", 4);
    look("3/0", 9);
    look("3/0 with room for 1", 1);
    mode(3, 2);
    write(port, "ab", 2);
    look("3/2 with 2 bytes", 9);
    write(port, "abcd", 4);
    look("3/2 with 4 bytes", 9);
    look("3/2 with 1 byte there", 9);
    mode(3, 0);
    fcntl(port, F_SETFL, O_NONBLOCK);
    look("3/0 without waiting", 9);
    write(port, "ab", 2);
    struct pollfd question = {port, POLLIN, 0};
    long long start = now();
    int ready = poll(&question, 1, 500);
    printf("poll: %d after %lld\n", ready, now() - start);
    look("3/0 without waiting, with 2 bytes", 9);
    return 0;
}
