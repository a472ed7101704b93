:- module(facetlog_python, [ define_python/3,       % +Base, +Indicator, +Key
                             undefine_python/1,     % +Base
                             python_predicate/3,    % +Base, ?Indicator, -Key
                             call_python/2          % +Key, ?Args
                           ]).

/** <module> Python functions as predicates

A function is called with all its arguments and says all its solutions at once. What it raises
becomes error(python_error(Key, Message), _); the same exception is raised again in Python if no
one catches it here.
*/

:- use_module(library(lists)).
:- use_module(facetlog_kb(json)).

%!  python_predicate(+Base, ?Indicator, -Key) is nondet.
%
%   The function of that Key answers for Indicator (Name/Arity) in Base.

:- dynamic python_predicate/3.

%!  define_python(+Base, +Indicator, +Key) is det.
%
%   In the place of what Base had for Indicator.

define_python(Base, Indicator, Key) :-
    retractall(python_predicate(Base, Indicator, _)),
    assertz(python_predicate(Base, Indicator, Key)).

%!  undefine_python(+Base) is det.
%
%   Forgets all of Base.

undefine_python(Base) :-
    retractall(python_predicate(Base, _, _)).

%!  call_python(+Key, ?Args) is nondet.
%
%   Args is one of the solutions, in the function's order.
%
%   @error python_error(Number, Message) if it raises something

call_python(Key, Args) :-
    json([Key|Args], Request),
    facetlog_bridge:python(Request, Reply),
    term_string(Said, Reply),
    (   Said = raised(Number, Message)
    ->  throw(error(python_error(Number, Message), _))
    ;   Said = solutions(Rows),
        member(Args, Rows)
    ).
