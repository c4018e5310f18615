#include "client/remote.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "client/interrupt.h"
#include "client/job_file.h"
#include "client/report_page.h"

int remote_fail(const fault_t *fault)
{
    fprintf(stderr, "garland: %s\n", fault->text);
    return STATUS_FAILURE;
}

/* The first line of a small file, if one is named; the caller frees. */
static fault_code_t read_secret(const char *path, char **out, fault_t *fault)
{
    uint8_t *text;
    size_t size;
    if (!path)
        return FAULT_NONE;
    TRY(file_read(path, 4096, &text, &size, fault));
    *out = (char *)text;
    (*out)[strcspn(*out, "\r\n")] = '\0';
    return FAULT_NONE;
}

bool remote_open(remote_t *remote, const char *command, int *status)
{
    fault_t fault = {0};
    if (!remote->address)
        remote->address = getenv("GARLAND_MASTER");
    if (!remote->address) {
        *status = options_refuse(command, "--master ADDR is missing");
        return false;
    }
    interrupt_catch();
    fault_code_t code = read_secret(remote->token_file, &remote->token, &fault);
    if (code == FAULT_NONE)
        code = read_secret(remote->key_file, &remote->server_key, &fault);
    const link_options_t options = {.token = remote->token, .server_key = remote->server_key};
    if (code == FAULT_NONE)
        code = link_open(&remote->link, remote->address, &options, &fault);
    if (code != FAULT_NONE) {
        *status = remote_fail(&fault);
        if (code == FAULT_USAGE)
            *status = STATUS_USAGE;
        remote_close(remote);
        return false;
    }
    return true;
}

void remote_close(remote_t *remote)
{
    link_close(&remote->link);
    free(remote->token);
    free(remote->server_key);
    remote->token = remote->server_key = NULL;
}

uint64_t remote_job(const char *command, const char *text)
{
    char *end;
    errno = 0;
    const uint64_t job = strtoull(text, &end, 10);
    if (text[0] < '1' || text[0] > '9' || *end != '\0' || errno != 0) {
        options_refuse(command, "\"%s\" is no job's number", text);
        return 0;
    }
    return job;
}

static fault_code_t fetch_one(link_t *link, uint64_t job, message_output_t output, const char *path, fault_t *fault)
{
    uint8_t *data;
    size_t size;
    TRY(link_fetch(link, job, output, &data, &size, fault));
    const fault_code_t code = file_write(path, data, size, fault);
    free(data);
    return code;
}

/* Says one output's fate: a line on standard output, or the first fault. */
static void note_output(const char *name, const char *path, fault_code_t code, const fault_t *own, bool print,
                        fault_code_t *first, fault_t *fault)
{
    if (code == FAULT_NONE && print)
        printf("  %-8s %s\n", name, path);
    if (code != FAULT_NONE && *first == FAULT_NONE)
        *first = fault_set(fault, code, "%s: %s", name, own->text);
}

fault_code_t remote_fetch_outputs(link_t *link, uint64_t job, const job_t *description, const char *folder,
                                  bool print, fault_t *fault)
{
    fault_code_t first = FAULT_NONE;
    char path[JOB_PATH_SIZE];
    bool wanted = true;
    for (int output = MESSAGE_OUTPUT_IMAGE; output <= MESSAGE_OUTPUT_REPORT; output++) {
        fault_t own = {0};
        fault_code_t code = job_file_output(description, (message_output_t)output, folder, path, &wanted, &own);
        if (code == FAULT_NONE && wanted)
            code = fetch_one(link, job, (message_output_t)output, path, &own);
        note_output(job_file_output_name((message_output_t)output), path, code, &own, print && wanted, &first,
                    fault);
    }
    fault_t own = {0};
    fault_code_t code = job_file_page(description, folder, path, &wanted, &own);
    if (code == FAULT_NONE && wanted)
        code = report_page_fetch(link, job, path, &own);
    note_output("page", path, code, &own, print && wanted, &first, fault);
    return first;
}
