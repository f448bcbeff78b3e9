# SPDX-License-Identifier: GPL-2.0-or-later
# bash: the options of haptable's programs, as each one's --help lists them; files otherwise.
_haptable() {
    local word=${COMP_WORDS[COMP_CWORD]}
    COMPREPLY=()
    [[ $word == -* ]] || return 0
    mapfile -t COMPREPLY < <(compgen -W "$("$1" --help 2>/dev/null | grep -oE '(^|[ ,])--?[a-z][a-z-]*' | tr -d ' ,')" -- "$word")
}
complete -o default -F _haptable haptable-build haptable-precompute haptable-codegen haptable-device haptable-view \
    haptable-bridge haptable-run haptable-fit
