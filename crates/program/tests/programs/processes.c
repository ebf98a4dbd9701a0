// Children, pipes, signals and alarms. Prints what happens, and when.
#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static long long now(void) {
    struct timespec time;
    clock_gettime(CLOCK_REALTIME, &time);
    return time.tv_sec * 1000000000LL + time.tv_nsec - 1700000000000000000LL;
}

static volatile sig_atomic_t seen;

static void handler(int signal) { seen = signal; }

int main(void) {
    int ends[2], status;
    static char bytes[300000];
    setvbuf(stdout, NULL, _IONBF, 0);
    long total, count;
    for (int kind = 0; kind < 2; kind++) {
        if (kind == 0) pipe(ends);
        else socketpair(AF_UNIX, SOCK_STREAM, 0, ends);
        if (fork() == 0) {
            close(ends[0]);
            usleep(250000);
            int written = write(ends[1], bytes, sizeof bytes);
            exit(written == sizeof bytes ? 7 : 8);
        }
        close(ends[1]);
        for (total = 0; (count = read(ends[0], bytes, sizeof bytes)) > 0; total += count) {}
        wait(&status);
        printf("%ld bytes, exit %d at %lld\n", total, WEXITSTATUS(status), now());
    }
    struct sigaction action = {.sa_handler = handler};
    sigaction(SIGALRM, &action, NULL);
    sigaction(SIGUSR1, &action, NULL);
    alarm(2);
    struct timespec five = {5, 0}, left;
    int answer = nanosleep(&five, &left);
    printf("sleep %d %d left %ld at %lld\n", answer, errno == EINTR, left.tv_sec, now());
    alarm(1);
    answer = pause();
    printf("pause %d %d signal %d at %lld\n", answer, errno == EINTR, (int)seen, now());
    pid_t parent = getpid(), child = fork();
    if (child == 0) {
        usleep(100000);
        kill(parent, SIGUSR1);
        for (;;) sleep(1000);
    }
    pipe(ends);
    answer = read(ends[0], bytes, 1);
    printf("read %d %d signal %d at %lld\n", answer, errno == EINTR, seen == SIGUSR1, now());
    kill(child, SIGKILL);
    waitpid(child, &status, 0);
    printf("killed %d at %lld\n", WTERMSIG(status), now());
    pipe(ends);
    if (fork() == 0) usleep(50000), exit(0);
    close(ends[1]);
    struct pollfd question = {ends[0], POLLIN, 0};
    answer = poll(&question, 1, 1000);
    printf("poll %d %x at %lld\n", answer, question.revents, now());
    wait(&status);
    return system("sleep 0.25; exit 3") >> 8;
}
