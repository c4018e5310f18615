/* commands.h: the subcommands of `garland`, one file each. argv begins after the subcommand's name; the exit status
 * is returned (options.h). */
#ifndef CLIENT_COMMANDS_H
#define CLIENT_COMMANDS_H

int command_render(int argc, char **argv);
int command_plan(int argc, char **argv);
int command_pack(int argc, char **argv);
int command_submit(int argc, char **argv);
int command_status(int argc, char **argv);
int command_fetch(int argc, char **argv);
int command_cancel(int argc, char **argv);
int command_compare(int argc, char **argv);
int command_bench(int argc, char **argv);
int command_report(int argc, char **argv);
int command_lab(int argc, char **argv);

#endif
