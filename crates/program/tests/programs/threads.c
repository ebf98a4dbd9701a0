// Threads with a mutex, a condition, a semaphore, time-outs and joins. Prints the order in which things happen, and when.
#include <errno.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdio.h>
#include <time.h>
#include <unistd.h>

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t condition = PTHREAD_COND_INITIALIZER;
static sem_t semaphore;
static int count;

static long long now(void) {
    struct timespec time;
    clock_gettime(CLOCK_REALTIME, &time);
    return time.tv_sec * 1000000000LL + time.tv_nsec - 1700000000000000000LL;
}

static void *worker(void *number) {
    for (int i = 0; i < 3; i++) {
        usleep(10000 + 1000 * (long)number);
        pthread_mutex_lock(&mutex);
        count++;
        printf("worker %ld at %lld\n", (long)number, now());
        pthread_cond_broadcast(&condition);
        pthread_mutex_unlock(&mutex);
        sem_post(&semaphore);
    }
    return NULL;
}

static void *sleeper(void *unused) {
    usleep(1000);
    return NULL;
}

int main(void) {
    pthread_t threads[4];
    sem_init(&semaphore, 0, 0);
    for (long i = 0; i < 4; i++) pthread_create(&threads[i], NULL, worker, (void *)i);
    pthread_mutex_lock(&mutex);
    while (count < 12) pthread_cond_wait(&condition, &mutex);
    pthread_mutex_unlock(&mutex);
    for (int i = 0; i < 12; i++) sem_wait(&semaphore);
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_sec += 2;
    int answer = sem_timedwait(&semaphore, &until);
    for (int i = 0; i < 4; i++) pthread_join(threads[i], NULL);
    printf("%d %d at %lld\n", answer, errno == ETIMEDOUT, now());
    pthread_create(&threads[0], NULL, sleeper, NULL);
    pthread_join(threads[0], NULL);
    printf("joined at %lld\n", now());
    return 0;
}
