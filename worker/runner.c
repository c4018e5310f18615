#include "worker/runner.h"

#include <errno.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

/* A scene, open or being opened. Guarded by the runner's mutex; `handle` is set once. */
typedef struct scene_entry {
    struct scene_entry *next;
    source_t *source;
    void *handle;
    bool opening;
    unsigned users; /* threads whose workspace or unit needs it */
    uint64_t used;  /* runner's clock when last taken */
} scene_entry_t;

typedef struct task {
    struct task *next;
    message_lease_t lease;
    source_t *source;
    atomic_bool cancel;
    uint8_t *result;
    size_t result_size;
    fault_t fault;
    size_t record_size;
    uint8_t record[];
} task_t;

typedef struct task_list {
    task_t *first, **last;
} task_list_t;

typedef struct worker_thread {
    runner_t *runner;
    pthread_t thread;
    task_t *running;      /* guarded by the runner's mutex */
    scene_entry_t *scene; /* that the space belongs to; the thread's own, as is: */
    void *space;
} worker_thread_t;

struct runner {
    engine_t engine;
    pthread_mutex_t mutex;
    pthread_cond_t changed; /* a unit came, a scene was opened, or stop */
    bool stop;
    task_list_t queue, done;
    scene_entry_t *scenes;
    unsigned open_scenes;
    uint64_t clock;
    int wake_fd;
    unsigned thread_count;
    worker_thread_t threads[];
};

/* ---- lists of tasks ---- */

static void list_clear(task_list_t *list)
{
    list->first = NULL;
    list->last = &list->first;
}

static void list_append(task_list_t *list, task_t *task)
{
    task->next = NULL;
    *list->last = task;
    list->last = &task->next;
}

/* Takes out what *link points to. */
static task_t *list_take(task_list_t *list, task_t **link)
{
    task_t *task = *link;
    *link = task->next;
    if (list->last == &task->next)
        list->last = link;
    task->next = NULL;
    return task;
}

static void task_free(task_t *task)
{
    source_release(&task->source);
    free(task->result);
    free(task);
}

/* Under the mutex. */
static void finish_task(runner_t *runner, task_t *task)
{
    list_append(&runner->done, task);
    eventfd_write(runner->wake_fd, 1); /* fails only at 2^64 - 2 outcomes not taken */
}

/* ---- scenes (under the mutex unless said otherwise) ---- */

static scene_entry_t *find_scene(runner_t *runner, const source_t *source)
{
    for (scene_entry_t *entry = runner->scenes; entry; entry = entry->next)
        if (source_equal(entry->source, source))
            return entry;
    return NULL;
}

static void unlink_scene(runner_t *runner, scene_entry_t *entry)
{
    scene_entry_t **link = &runner->scenes;
    while (*link != entry)
        link = &(*link)->next;
    *link = entry->next;
}

/* Takes the scenes that may go out of the table, longest unused first; returns them as a list. */
static scene_entry_t *take_surplus(runner_t *runner, unsigned keep)
{
    scene_entry_t *surplus = NULL;
    for (;;) {
        unsigned count = 0;
        scene_entry_t *oldest = NULL;
        for (scene_entry_t *entry = runner->scenes; entry; entry = entry->next) {
            count++;
            if (!entry->opening && entry->users == 0 && (!oldest || entry->used < oldest->used))
                oldest = entry;
        }
        if (count <= keep || !oldest)
            return surplus;
        unlink_scene(runner, oldest);
        oldest->next = surplus;
        surplus = oldest;
    }
}

/* Without the mutex. */
static void close_scenes(runner_t *runner, scene_entry_t *list)
{
    while (list) {
        scene_entry_t *next = list->next;
        if (list->handle)
            runner->engine.close(list->handle);
        source_release(&list->source);
        free(list);
        list = next;
    }
}

/* With the mutex, which it gives up meanwhile. */
static void close_surplus(runner_t *runner)
{
    scene_entry_t *surplus = take_surplus(runner, runner->open_scenes);
    if (!surplus)
        return;
    pthread_mutex_unlock(&runner->mutex);
    close_scenes(runner, surplus);
    pthread_mutex_lock(&runner->mutex);
}

/* The open scene of a source with one more user. The caller has seen that no other thread is opening it; the mutex
 * is given up while it is opened. Null: it could not be, and fault says why. */
static scene_entry_t *acquire_scene(runner_t *runner, source_t *source, fault_t *fault)
{
    scene_entry_t *entry = find_scene(runner, source);
    if (entry) {
        entry->users++;
        entry->used = ++runner->clock;
        return entry;
    }
    entry = calloc(1, sizeof *entry);
    if (!entry) {
        fault_set(fault, FAULT_MEMORY, "no memory for a scene");
        return NULL;
    }
    *entry = (scene_entry_t){.next = runner->scenes, .source = source_share(source), .opening = true, .users = 1};
    runner->scenes = entry;
    pthread_mutex_unlock(&runner->mutex);
    const fault_code_t code = runner->engine.open(runner->engine.context, source, &entry->handle, fault);
    pthread_mutex_lock(&runner->mutex);
    entry->opening = false;
    entry->used = ++runner->clock;
    pthread_cond_broadcast(&runner->changed);
    if (code == FAULT_NONE)
        return entry;
    unlink_scene(runner, entry);
    source_release(&entry->source);
    free(entry);
    return NULL;
}

/* ---- a thread ---- */

/* Without the mutex. */
static void drop_space(worker_thread_t *self)
{
    runner_t *runner = self->runner;
    if (!self->scene)
        return;
    if (self->space)
        runner->engine.space_destroy(self->space);
    self->space = NULL;
    pthread_mutex_lock(&runner->mutex);
    self->scene->users--;
    self->scene = NULL;
    close_surplus(runner);
    pthread_mutex_unlock(&runner->mutex);
}

/* The unit to run next, taken out of the queue: one of the thread's own source if there is one, else the first
 * whose scene is not just being opened by another thread. Under the mutex. */
static task_t *take_task(worker_thread_t *self)
{
    runner_t *runner = self->runner;
    task_t **choice = NULL;
    for (task_t **link = &runner->queue.first; *link; link = &(*link)->next) {
        if (self->scene && source_equal((*link)->source, self->scene->source))
            return list_take(&runner->queue, link);
        const scene_entry_t *entry = find_scene(runner, (*link)->source);
        if (!choice && !(entry && entry->opening))
            choice = link;
    }
    return choice ? list_take(&runner->queue, choice) : NULL;
}

static unsigned count_scenes(const runner_t *runner)
{
    unsigned count = 0;
    for (const scene_entry_t *entry = runner->scenes; entry; entry = entry->next)
        count++;
    return count;
}

/* Makes the thread's space one of the task's source. */
static fault_code_t take_space(worker_thread_t *self, task_t *task)
{
    runner_t *runner = self->runner;
    if (self->space && source_equal(self->scene->source, task->source))
        return FAULT_NONE;
    drop_space(self);
    pthread_mutex_lock(&runner->mutex);
    const scene_entry_t *other = find_scene(runner, task->source);
    while (other && other->opening) { /* another thread began to between two locks */
        pthread_cond_wait(&runner->changed, &runner->mutex);
        other = find_scene(runner, task->source);
    }
    self->scene = acquire_scene(runner, task->source, &task->fault);
    pthread_mutex_unlock(&runner->mutex);
    if (!self->scene)
        return task->fault.code;
    const fault_code_t code = runner->engine.space_new(self->scene->handle, &self->space, &task->fault);
    if (code)
        drop_space(self);
    return code;
}

static void run_task(worker_thread_t *self, task_t *task)
{
    if (!atomic_load(&task->cancel) && take_space(self, task) == FAULT_NONE && !atomic_load(&task->cancel))
        self->runner->engine.run(self->space, task->record, task->record_size, &task->cancel, &task->result,
                                 &task->result_size, &task->fault);
    if (atomic_load(&task->cancel)) /* also where it came too late, or another fault came first */
        fault_set(&task->fault, FAULT_CANCELLED, "cancelled");
    if (task->fault.code != FAULT_NONE) {
        free(task->result);
        task->result = NULL;
        task->result_size = 0;
    }
}

static void *thread_main(void *argument)
{
    worker_thread_t *self = argument;
    runner_t *runner = self->runner;
    pthread_mutex_lock(&runner->mutex);
    while (!runner->stop) {
        task_t *task = take_task(self);
        if (!task && self->scene && count_scenes(runner) > runner->open_scenes) {
            pthread_mutex_unlock(&runner->mutex); /* an idle thread does not hold what others need room for */
            drop_space(self);
            pthread_mutex_lock(&runner->mutex);
            continue;
        }
        if (!task) {
            pthread_cond_wait(&runner->changed, &runner->mutex);
            continue;
        }
        self->running = task;
        pthread_mutex_unlock(&runner->mutex);
        run_task(self, task);
        pthread_mutex_lock(&runner->mutex);
        self->running = NULL;
        finish_task(runner, task);
    }
    pthread_mutex_unlock(&runner->mutex);
    drop_space(self);
    return NULL;
}

/* ---- the pool ---- */

static fault_code_t start_threads(runner_t *runner, unsigned threads, fault_t *fault)
{
    for (unsigned i = 0; i < threads; i++) {
        runner->threads[i].runner = runner;
        const int error = pthread_create(&runner->threads[i].thread, NULL, thread_main, &runner->threads[i]);
        if (error)
            return fault_set(fault, FAULT_IO, "cannot start thread %u of %u: %s", i + 1, threads, strerror(error));
        runner->thread_count = i + 1;
    }
    return FAULT_NONE;
}

fault_code_t runner_new(runner_t **out, const runner_options_t *options, const engine_t *engine, fault_t *fault)
{
    *out = NULL;
    if (options->threads < 1 || options->threads > RUNNER_MAX_THREADS)
        return fault_set(fault, FAULT_RANGE, "%u threads, expected 1 to %d", options->threads, RUNNER_MAX_THREADS);
    runner_t *runner = calloc(1, sizeof *runner + options->threads * sizeof *runner->threads);
    if (!runner)
        return fault_set(fault, FAULT_MEMORY, "no memory for %u threads", options->threads);
    runner->engine = *engine;
    runner->open_scenes = options->open_scenes ? options->open_scenes : RUNNER_OPEN_SCENES;
    list_clear(&runner->queue);
    list_clear(&runner->done);
    pthread_mutex_init(&runner->mutex, NULL);
    pthread_cond_init(&runner->changed, NULL);
    runner->wake_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    const fault_code_t code = runner->wake_fd < 0
                                  ? fault_set(fault, FAULT_IO, "cannot make an eventfd: %s", strerror(errno))
                                  : start_threads(runner, options->threads, fault);
    if (code)
        runner_destroy(&runner);
    *out = runner;
    return code;
}

static void free_tasks(task_list_t *list)
{
    while (list->first)
        task_free(list_take(list, &list->first));
}

void runner_destroy(runner_t **runner)
{
    runner_t *r = *runner;
    *runner = NULL;
    if (!r)
        return;
    pthread_mutex_lock(&r->mutex);
    r->stop = true;
    for (unsigned i = 0; i < r->thread_count; i++)
        if (r->threads[i].running)
            atomic_store(&r->threads[i].running->cancel, true);
    pthread_cond_broadcast(&r->changed);
    pthread_mutex_unlock(&r->mutex);
    for (unsigned i = 0; i < r->thread_count; i++)
        pthread_join(r->threads[i].thread, NULL);
    close_scenes(r, take_surplus(r, 0));
    free_tasks(&r->queue);
    free_tasks(&r->done);
    if (r->wake_fd >= 0)
        close(r->wake_fd);
    pthread_cond_destroy(&r->changed);
    pthread_mutex_destroy(&r->mutex);
    free(r);
}

fault_code_t runner_submit(runner_t *runner, const runner_unit_t *unit, fault_t *fault)
{
    task_t *task = calloc(1, sizeof *task + unit->record.size);
    if (!task)
        return fault_set(fault, FAULT_MEMORY, "no memory for a unit's record of %zu octets", unit->record.size);
    task->lease = unit->lease;
    task->source = source_share(unit->source);
    atomic_init(&task->cancel, false);
    task->record_size = unit->record.size;
    if (unit->record.size)
        memcpy(task->record, unit->record.data, unit->record.size);
    pthread_mutex_lock(&runner->mutex);
    list_append(&runner->queue, task);
    pthread_cond_broadcast(
        &runner->changed); /* not signal: the thread it wakes might not be one that may take it */
    pthread_mutex_unlock(&runner->mutex);
    return FAULT_NONE;
}

void runner_cancel(runner_t *runner, uint64_t job)
{
    pthread_mutex_lock(&runner->mutex);
    for (task_t **link = &runner->queue.first; *link;) {
        if ((*link)->lease.job != job) {
            link = &(*link)->next;
            continue;
        }
        task_t *task = list_take(&runner->queue, link);
        fault_set(&task->fault, FAULT_CANCELLED, "cancelled");
        finish_task(runner, task);
    }
    for (unsigned i = 0; i < runner->thread_count; i++)
        if (runner->threads[i].running && runner->threads[i].running->lease.job == job)
            atomic_store(&runner->threads[i].running->cancel, true);
    pthread_mutex_unlock(&runner->mutex);
}

bool runner_take(runner_t *runner, runner_outcome_t *outcome)
{
    pthread_mutex_lock(&runner->mutex);
    task_t *task = runner->done.first ? list_take(&runner->done, &runner->done.first) : NULL;
    if (!task) {
        eventfd_t count;
        eventfd_read(runner->wake_fd, &count); /* fails if it was clear already */
    }
    pthread_mutex_unlock(&runner->mutex);
    if (!task)
        return false;
    outcome->lease = task->lease;
    outcome->result = task->result;
    outcome->size = task->result_size;
    outcome->fault = task->fault;
    task->result = NULL;
    task_free(task);
    return true;
}

int runner_wake_fd(const runner_t *runner)
{
    return runner->wake_fd;
}

unsigned runner_threads(const runner_t *runner)
{
    return runner->thread_count;
}

unsigned runner_open_scenes(runner_t *runner)
{
    pthread_mutex_lock(&runner->mutex);
    const unsigned count = count_scenes(runner);
    pthread_mutex_unlock(&runner->mutex);
    return count;
}
