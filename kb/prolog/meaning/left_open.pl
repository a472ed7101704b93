:- module(facetlog_left_open, [ blocks/4              % +Module, +Model, +Candidates, -Blocks
                              ]).

/** <module> Where nothing can hold

A thing of which nobody knows which way is up has no level face for certain: a model that wants one is
unknown whatever faces are chosen, and thousands of choices may be equally open. The first that does
not fail then settles what the verdict is.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(say)).
:- use_module(facetlog_kb(variables)).
:- use_module(facetlog_kb(in_progress)).

%   As many as are tried for the first of several parts that may be unseen (joins.py): so many are searched
%   for the best of them before it is asked whether others can be better.
block_size(6).

%!  blocks(+Module, +Model, +Candidates, -Blocks) is det.
%
%   Candidates, a sorted list of Thing-Parts, in lists that follow each other; there is but one unless
%   none of Candidates can hold. An assignment that does not fail is then as good as any: who finds
%   one in a block need not search the next.

blocks(Module, Model, Candidates, Blocks) :-
    block_size(Size),
    length(Block, Size),
    (   append(Block, [Next|Rest], Candidates),
        none_holds(Module, Model, Candidates)
    ->  Blocks = [Block|Others],
        split([Next|Rest], Size, Others)
    ;   Blocks = [Candidates]
    ).

split(Candidates, Size, Blocks) :-
    length(Block, Size),
    (   append(Block, [Next|Rest], Candidates)
    ->  Blocks = [Block|Others],
        split([Next|Rest], Size, Others)
    ;   Blocks = [Candidates]
    ).

%   A condition that asks for few of the parts, the fewest first, holds for none of those that are
%   proposed for them.
none_holds(Module, Model, Candidates) :-
    findall(Count-line(Thing, Parts, Some, Test),
            ( clause(Module:condition(Model, _, _, Thing, Parts, Test), true),
              some_parts(Thing, Parts, Test, Some),
              length(Some, Count) ),
            Lines0),
    keysort(Lines0, Lines),
    member(_-line(Thing, Parts, Some, Test), Lines),
    findall(Thing-Some, member(Thing-Parts, Candidates), All),
    sort(All, Distinct),
    \+ ( member(Thing-Some, Distinct), may_hold(Module, Model, Thing, Test) ),
    !.

%   Some are the variables of parts in Test: one, or at least not all there are.
some_parts(Thing, Parts, Test, Some) :-
    var(Thing),
    nonvar(Test),
    term_variables(Parts, PartVariables),
    term_variables(Test, TestVariables),
    include(among(TestVariables), PartVariables, Some),
    ( Some = [_] -> true ; \+ same_length(Some, PartVariables) ).

may_hold(Module, Model, Thing, Test) :-
    while_judging(Module, Model, Thing, outline(Test, Module, Outline)),
    Outline = outline(holds, _, _, _).
