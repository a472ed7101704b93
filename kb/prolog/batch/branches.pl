:- module(facetlog_branches, [ copies/4,            % +Seen, +Seen1, +Condition, -Copies
                               bound_in_branch/3,   % +Copies, +Code0, -Code
                               shared/3,            % +Goal, +Code, -Shared
                               both/3,              % +Code, +Code, -Code
                               either/3             % +Code, +Code, -Code
                             ]).

/** <module> Goals that are written in branches

What partial.pl finds out in a branch is true where the branch is taken: each is written with variables of
its own, and those that others see are then given their names again.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(pairs)).
:- use_module(library(ordsets)).
:- use_module(facetlog_kb(target)).

%!  copies(+Seen, +Seen1, +Condition, -Copies) is det.
%
%   Seen1 is a copy of Seen. Copies are Variable-Copy of what others see, those first that the condition
%   mentions: of two that a branch makes the same, the first keeps its name.
copies(Seen, Seen1, Condition, Copies) :-
    term_variables(Seen, Variables),
    copy_term(Seen-Variables, Seen1-Values),    % Seen1 is an instance of Seen
    pairs_keys_values(Pairs, Variables, Values),
    term_variables(Condition, Mentioned),
    (   Mentioned == []
    ->  Copies = Pairs
    ;   partition(copy_among(Mentioned), Pairs, First, Others),
        append(First, Others, Copies)
    ).

%!  bound_in_branch(+Copies, +Code0, -Code) is det.
%
%   What a branch bound of the variables that others see, it binds when it is taken.
bound_in_branch(Pairs, Code0, Code) :-
    partition(free_copy, Pairs, Free, Bound),
    bindings(Free, [], Same),
    pairs_keys_values(Bound, BoundVariables, Values),
    maplist(binding, BoundVariables, Values, Bindings),
    foldl(both, Bindings, Code0, Code1),
    foldl(both, Same, Code1, Code).

free_copy(_-Copy) :- var(Copy).

binding(Variable, Value, Variable = Value).

copy_among(Mentioned, _-Copy) :-
    var(Copy),
    among(Mentioned, Copy).

bindings([], _, []).
bindings([Variable-Copy|Pairs], Done, Bindings) :-
    (   \+ among(Done, Copy)
    ->  Copy = Variable,
        bindings(Pairs, [Variable|Done], Bindings)
    ;   Bindings = [Variable = Copy|Bindings1],
        bindings(Pairs, Done, Bindings1)
    ).

%!  shared(+Goal, +Code, -Shared) is det.
%
%   The variables of Goal that Code before it asks for or finds.
shared(Goal, Code, Shared) :-
    term_variables(Goal, Variables),
    term_variables(Code, Known0),
    sort(Variables, Sorted),
    sort(Known0, Known),
    ord_intersection(Sorted, Known, Shared).

%!  both(+A, +B, -Code) is det.
%!  either(+A, +B, -Code) is det.
%
%   A conjunction or disjunction, simplified.

both(true, Code, Code) :- !.
both(_, fail, fail) :- !.
both(Code, true, Code) :- !.
both(A, B, ( A, B )).

either(fail, Code, Code) :- !.
either(Code, fail, Code) :- !.
either(A, B, ( A ; B )).
