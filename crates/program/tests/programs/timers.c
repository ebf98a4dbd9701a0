// Timers of all kinds: with signals, threads and descriptors. Prints what rings, and when.
#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <sys/epoll.h>
#include <sys/timerfd.h>
#include <time.h>
#include <unistd.h>

static long long now(void) {
    struct timespec time;
    clock_gettime(CLOCK_REALTIME, &time);
    return time.tv_sec * 1000000000LL + time.tv_nsec - 1700000000000000000LL;
}

static void handler(int signal, siginfo_t *info, void *unused) {
    printf("signal %d value %d timer %d at %lld\n", signal - SIGRTMIN, info->si_value.sival_int, info->si_code == SI_TIMER, now());
}

static void called(union sigval value) { printf("thread value %d at %lld\n", value.sival_int, now()); }

static void tell(const char *call, int answer) { printf("%s %d at %lld\n", call, answer, now()); }

static struct itimerspec times(long first_ms, long every_ms) {
    return (struct itimerspec){{0, every_ms * 1000000}, {first_ms / 1000, first_ms % 1000 * 1000000}};
}

int main(void) {
    timer_t timer, other;
    uint64_t rings;
    setvbuf(stdout, NULL, _IONBF, 0);
    struct sigaction action = {.sa_sigaction = handler, .sa_flags = SA_SIGINFO};
    sigaction(SIGRTMIN + 3, &action, NULL);
    struct sigevent event = {.sigev_notify = SIGEV_SIGNAL, .sigev_signo = SIGRTMIN + 3, .sigev_value.sival_int = 42};
    timer_create(CLOCK_MONOTONIC, &event, &timer);
    struct itimerspec wanted = times(100, 50), left;
    timer_settime(timer, 0, &wanted, NULL);
    usleep(30000);
    timer_gettime(timer, &left);
    printf("left %ld every %ld\n", left.it_value.tv_nsec, left.it_interval.tv_nsec);
    for (int i = 0; i < 3; i++) pause();
    printf("deleted %d\n", timer_delete(timer));
    event = (struct sigevent){.sigev_notify = SIGEV_THREAD, .sigev_notify_function = called, .sigev_value.sival_int = 7};
    timer_create(CLOCK_REALTIME, &event, &other);
    wanted = times(0, 0);
    wanted.it_value = (struct timespec){1700000001, 0};
    timer_settime(other, TIMER_ABSTIME, &wanted, NULL);
    usleep(1000000);
    printf("late %d at %lld\n", timer_settime(other, TIMER_ABSTIME, &wanted, NULL), now());
    usleep(1000);
    int file = timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC);
    wanted = times(250, 100);
    timerfd_settime(file, 0, &wanted, NULL);
    for (int i = 0; i < 2; i++) {
        read(file, &rings, sizeof rings);
        printf("%lu rings at %lld\n", rings, now());
    }
    usleep(350000);
    read(file, &rings, sizeof rings);
    printf("%lu rings at %lld\n", rings, now());
    struct pollfd question = {file, POLLIN, 0};
    tell("poll", poll(&question, 1, 20));
    tell("poll", poll(&question, 1, -1));
    int waits = epoll_create1(0);
    struct epoll_event told = {EPOLLIN | EPOLLET, {.u32 = 5}};
    epoll_ctl(waits, EPOLL_CTL_ADD, file, &told);
    for (int i = 0; i < 3; i++) tell("epoll", epoll_wait(waits, &told, 1, 1000));
    wanted = times(0, 0);
    timerfd_settime(file, 0, &wanted, &left);
    printf("left %ld every %ld\n", left.it_value.tv_nsec, left.it_interval.tv_nsec);
    tell("epoll", epoll_wait(waits, &told, 1, 1000));
    file = timerfd_create(CLOCK_REALTIME, TFD_NONBLOCK);
    long answer = read(file, &rings, sizeof rings);
    printf("read %ld %d\n", answer, errno == EAGAIN);
    return 0;
}
