// Does what has no simulated time, by its first word.
#define _GNU_SOURCE
#include <fcntl.h>
#include <netinet/in.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/inotify.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

int main(int count, char **words) {
    int ends[2];
    timer_t timer;
    char byte;
    if (!strcmp(words[1], "spin")) for (volatile int i = 0;; i++) {}
    if (!strcmp(words[1], "compute")) {
        for (int i = 0; i < 10; i++, time(NULL)) for (volatile int j = 0; j < 60000000; j++) {}
        return 0;
    }
    if (!strcmp(words[1], "deadlock")) {
        pipe(ends);
        read(ends[0], &byte, 1);
    }
    if (!strcmp(words[1], "hang")) {
        int lock = open(words[2], O_RDWR | O_CREAT, 0600);
        struct flock whole = {.l_type = F_WRLCK};
        fcntl(lock, F_SETLKW, &whole);
        if (fork() == 0) {
            lock = open(words[2], O_RDWR);
            fcntl(lock, F_SETLKW, &whole);
        }
        sleep(1000);
    }
    if (!strcmp(words[1], "network")) socket(AF_INET, SOCK_STREAM, 0);
    if (!strcmp(words[1], "old")) asm volatile("int $0x80" : : "a"(20));
    if (!strcmp(words[1], "timer")) timer_create(CLOCK_PROCESS_CPUTIME_ID, NULL, &timer);
    if (!strcmp(words[1], "inotify")) inotify_init();
    if (!strcmp(words[1], "terminal")) posix_openpt(O_RDWR);
    if (!strcmp(words[1], "unix")) {
        struct sockaddr_un address = {AF_UNIX, "/run/some/where"};
        connect(socket(AF_UNIX, SOCK_STREAM, 0), (void *)&address, sizeof address);
    }
    if (!strcmp(words[1], "poll")) for (;;) {
        int port = open("/dev/ttySIM0", O_RDWR | O_NONBLOCK);
        for (int i = 0; i < 1000; i++) if (read(port, &byte, 1) == 1) return 0;
        return 1;
    }
    if (!strcmp(words[1], "forks")) for (int i = 0; i < 3; i++) if (fork() == 0) for (;;) sleep(1);
    for (;;) sleep(1);
}
