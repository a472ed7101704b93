:- module(facetlog_from_source_code, [ each_from_code/6,       % +X, +From, +Test, +Context, -Code, -Outline
                                      some_from_code/6,       % +X, +From, +Test, +Context, -Code, -Outline
                                      each_pair_from_code/7   % +X, +Y, +From, +Test, +Context, -Code,
                                                              % -Outline
                                    ]).

/** <module> Quantifiers over what a source gives

From is from(X, Goals, Excluded, Test, Scope), a source (sources.pl) of which the list is not needed. A
step of the test that depends on few parts is asked of all that the source may give, once for these
parts, and what it says of each is kept as far as it says anything. The other steps are asked of one
after the other, until nothing more can change.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(target)).
:- use_module(facetlog_kb(seen_through)).
:- use_module(facetlog_kb(sources)).
:- use_module(facetlog_kb(body_code)).
:- use_module(facetlog_kb(outline_code)).

%!  each_from_code(+X, +From, +Test, +Context, -Code, -Outline) is det.

each_from_code(X, From, Test, Context, Code, Outline) :-
    one_of(X, _, Test, Fresh, lists:member(Y, _)),
    From = from(Z, Goals, Excluded, Possible, Scope),
    ( Fresh = all(Steps), is_list(Steps) -> true ; Steps = [Fresh] ),
    keyed(Steps, Z-Goals-Possible, Scope, Few, Many),
    groups(Few, Groups),
    foldl(table_code(Y, From, Context), Groups, []-true, Known-TablesCode),
    (   Many == []
    ->  Code = ( TablesCode, facetlog_outlines:all_of(outline, Known, Outline) )
    ;   ( Many = [Only] -> Whole = Only ; Whole = all(Many) ),
        outline_code(outline, Whole, Context, WholeCode, One),
        closure(Context, [Y, One], Scope, WholeCode, Closure),
        source_code(source(Z, Goals, Excluded, Possible, Xs), Scope, Context, SourceCode),
        Code = ( TablesCode, SourceCode,
                 facetlog_outlines:each_of(Xs, Closure, Known, Outline) )
    ).

%   Few are Inputs-Step, if they and the source depend on few parts.
keyed([], _, _, [], []).
keyed([Step|Steps], Source, Scope, Few, Many) :-
    Source = Z-Goals-Possible,
    Scope = scope(Thing, Parts, Derived0),
    term_variables(Z-Goals, Own),
    exclude(among(Own), Derived0, Derived),
    (   few_inputs(Goals-Possible-Step, scope(Thing, Parts, Derived), Inputs)
    ->  Few = [Inputs-Step|Few1],
        Many = Many1
    ;   Few = Few1,
        Many = [Step|Many1]
    ),
    keyed(Steps, Source, Scope, Few1, Many1).

step_of(_-Step, Step).

groups([], []).
groups([Inputs-Step|Keyed], [Inputs-[Step|Steps]|Groups]) :-
    partition(same_inputs(Inputs), Keyed, Same, Others),
    maplist(step_of, Same, Steps),
    groups(Others, Groups).

same_inputs(Inputs, Others-_) :- Inputs == Others.

table_code(Y, from(X, Goals, Excluded, Possible, _), Context, Inputs-Steps,
           Known0-Code0, Known-( Code0, Table, facetlog_outlines:of_others(Rows, Excluded, Known0, Known) )) :-
    copy_term(Inputs-Y-X-Goals-Possible-Steps, Inputs1-Y1-X1-Goals1-Possible1-Steps1),
    append(Inputs1, [Rows1], Args1),
    Context = context(Module, _, _),
    helper(Context, rows(Module, Inputs1, Y1, X1, Goals1, Possible1, Steps1), Args1, Head, New),
    (   New == true
    ->  all_code(source(X1, Goals1, [], Possible1, _), Inputs1, Context, All, AllCode),
        ( Steps1 = [Only] -> Whole = Only ; Whole = all(Steps1) ),
        outline_code(outline, Whole, Context, WholeCode, One),
        called(( lists:member(Y1, All), WholeCode, facetlog_outlines:changing(One) ),
               All-Y1-One-Inputs1, Context, Call),
        put_remembered(Context, Head, Inputs1, [Rows1], ( AllCode, findall(Y1-One, Call, Rows1) ))
    ;   true
    ),
    Head =.. [Name|_],
    append(Inputs, [Rows], Args),
    Table =.. [Name|Args].

%!  some_from_code(+X, +From, +Test, +Context, -Code, -Outline) is det.

some_from_code(X, from(Z, Goals, Excluded, Possible, Scope), Test, Context, Code, Outline) :-
    source_code(source(Z, Goals, Excluded, Possible, Xs), Scope, Context, SourceCode),
    one_of(X, _, Test, Fresh, lists:member(Y, _)),
    outline_code(outline, Fresh, Context, OneCode, One),
    closure(Context, [Y, One], Scope, OneCode, Closure),
    Code = ( SourceCode, facetlog_outlines:some_of(Xs, Closure, Outline) ).

%!  each_pair_from_code(+X, +Y, +From, +Test, +Context, -Code, -Outline) is det.

each_pair_from_code(X, Y, from(Z, Goals, Excluded, Possible, Scope), Test, Context, Code, Outline) :-
    source_code(source(Z, Goals, Excluded, Possible, Xs), Scope, Context, SourceCode),
    two_of(X, Y, _, Test, Fresh, facetlog_outlines:pair_of(_, A, B)),
    outline_code(outline, Fresh, Context, OneCode, One),
    closure(Context, [A, B, One], Scope, OneCode, Closure),
    Code = ( SourceCode, facetlog_outlines:each_pair_of(Xs, Closure, Outline) ).

%   A closure that lacks the arguments Last and does what Code does.
closure(Context, Last, Scope, Code, Target:Closure) :-
    Context = context(_, Target, _),
    inputs(Code, Scope, Inputs),
    append(Inputs, Last, Args),
    helper(Context, step(Code, Args), Args, Head, New),
    ( New == true -> put_clause(Context, (Head :- Code)) ; true ),
    Head =.. [Name|_],
    Closure =.. [Name|Inputs].
