:- module(facetlog_first_answer, [ first_answer_code/6   % +Measure, -V, -Sd, -Kind, +Context, -Code
                                 ]).

/** <module> Measures into goals

The first clause of measure/4 that knows a measure counts.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(facetlog_kb(target)).
:- use_module(facetlog_kb(body_code)).
:- use_module(facetlog(measures)).

%!  first_answer_code(+Measure, -V, -Sd, -Kind, +Context, -Code) is det.
%
%   Code finds the value and its deviation, once, or fails where the scene does not know. Where all
%   clauses give one deviation, that is known now.
%
%   @throws facetlog_unknown(Measure) if its kind is not known beforehand.

first_answer_code(Measure, V, Sd, Kind, Context, Code) :-
    findall(measure(Measure, V0, Sd0, Kind0, Body),
            clause(measures:measure(Measure, V0, Sd0, Kind0), Body),
            Found),
    (   Found == []
    ->  Code = fail
    ;   maplist(kind_of(Kind), Found),
        nonvar(Kind)
    ->  code(Found, Measure, Context, Code, V, Sd)
    ;   throw(facetlog_unknown(Measure))
    ).

kind_of(Kind, measure(_, _, _, Kind, _)).

%   What is not a plain fact is worked out once a scene.
code([measure(Measure, V, Sd, _, fact(Fact))], Measure, Context, Code, V, Sd) :-
    !,
    body_code(measures:fact(Fact), Context, Code).
code([measure(Measure, V1, Sd1, _, fact(Fact))|Found], Measure, Context, Code, V, Sd) :-
    var(V1),
    var(Sd1),
    !,
    V1 = V,
    Sd1 = Sd,
    body_code(measures:fact(Fact), Context, First),
    code(Found, Measure, Context, Rest, V, Sd2),
    Code = ( First -> true ; Rest, Sd = Sd2 ).
code(Found, Measure, Context, Code, V, Sd) :-
    term_variables(Measure, Args),
    copy_term(Measure-Args, General-Generals),
    append(Generals, [V0, Sd0], HeadArgs),
    helper(Context, measure(General), HeadArgs, Head, New),
    (   New == true
    ->  findall(found(General, V1, Sd1, Body),
                ( member(measure(General, V1, Sd1, _, Body0), Found),
                  body_code(measures:Body0, Context, Body) ),
                Bodies),
        foldl(first_body(General, V0, Sd0), Bodies, fail, Any),
        put_remembered(Context, Head, Generals, [V0, Sd0], Any)
    ;   true
    ),
    append(Args, [V, Sd], CallArgs),
    Head =.. [Name|_],
    Code =.. [Name|CallArgs].

first_body(General, V, Sd, found(General, V1, Sd1, Body), Before,
           ( Before ; Body, V = V1, Sd = Sd1 )).
