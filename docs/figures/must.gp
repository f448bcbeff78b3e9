# @must (CONDITION) 'WHAT': ends gnuplot with an error where a figure, `name`, does not show what it is about.
if (ARG1 != 1) { print sprintf("%s: is to show %s", name, ARG2); exit status 1 }
