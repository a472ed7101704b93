:- module(facetlog_loops, [ loop/4,             % +Goal, +Module, +Context, -Code
                            shaped/1            % +Goal
                          ]).

/** <module> Loops over lists that only a scene has

A predicate of say.pl that goes through a list with a test, for partial.pl: the test and how it is joined
are known, the list, the parts that the test asks for and the sum so far are arguments.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(target)).
:- use_module(facetlog_kb(partial)).

%!  loop(+Goal, +Module, +Context, -Code) is semidet.
%
%   Code calls a predicate of the target for Goal, if Goal is a loop over a list that is not known.
loop(Goal, Module, Context, Code) :-
    loop_over(Goal, List, Patterns, Fixed, Sum0, Sum),
    var(List),
    term_variables(Patterns, Locals),
    term_variables(Fixed, Variables),
    exclude(among(Locals), Variables, Inputs),
    sum_shape(Sum0, Shape0),
    shaped(Goal),
    general(Goal, Sum0, Shape0, Values, General),
    term_variables(Shape0, Before),
    term_variables(Sum, After),
    append([[Values], Inputs, Before, After], Args),
    copy_term(General-Args, General1-Args1),
    helper(Context, General1, Args1, Head, New),
    ( New == true -> loop_clauses(General1, Module, Head, Context) ; true ),
    Head =.. [Name|_],
    leaves(Shape0, Sum0, Leaves),
    append([[List], Inputs, Leaves, After], CallArgs),
    Code =.. [Name|CallArgs].

loop_over(each_of(List, X, Test, _, _, _, Sum0, Sum), List, [X], Test, Sum0, Sum).
loop_over(each_pair_of(List, X, Y, Test, _, _, _, Sum0, Sum), List, [X, Y], Test, Sum0, Sum).
loop_over(each_with(List, Value, X, Y, Test, _, _, _, Sum0, Sum), List, [X, Y], Value-Test, Sum0,
          Sum).
loop_over(each_group(List, X, Test, _, _, _, Sum0, Sum), List, [X], Test, Sum0, Sum).

%!  shaped(+Goal) is det.
%
%   What comes of a loop has the shape of what it begins with.
shaped(Goal) :-
    (   ( loop_over(Goal, _, _, _, Sum0, Sum) ; Goal = each_test(_, _, _, _, Sum0, Sum) )
    ->  sum_shape(Sum0, Sum)
    ;   true
    ).

%   A sum with variables for all that changes from one element to the next.
sum_shape(Sum, Shape) :-
    (   nonvar(Sum),
        Sum = sum(_, Degree)
    ->  Shape = sum(_, Shape1),
        degree_shape(Degree, Shape1)
    ;   true                            % a list of what was said, or not known
    ).

degree_shape(none, none).
degree_shape(degree(_, _, Miss), degree(_, _, Shape)) :-
    ( nonvar(Miss), Miss = left(_, _) -> Shape = left(_, _) ; true ).

%   The test may ask for the same list: there it is another.
general(Goal, Sum0, Shape0, Values, General) :-
    Goal =.. [Name, _|Args0],
    append(Before, [Old, Sum], Args0),
    Old == Sum0,
    append(Before, [Shape0, Sum], Args),
    General =.. [Name, Values|Args].

leaves(Shape, Sum, Leaves) :-
    term_variables(Shape, Variables),
    copy_term(Shape-Variables, Sum-Leaves).

loop_clauses(General, Module, Head, Context) :-
    findall(General-Head-Body, clause(Module:General, Body), Clauses),
    forall(member(General-Head-Body, Clauses),
           ( residual(Body, Module, Context, Head, Code),
             put_clause(Context, (Head :- Code)) )).
