:- module(facetlog_white_list, [ allowed/2,           % ?Head, ?Meaning
                                 allowed_word/2,      % +Goal, -Head
                                 arithmetic/1,        % ?Indicator
                                 furnish/1            % +Module
                               ]).

/** <module> What of Prolog rules and questions may call

What is not on the list is refused, so nothing has to be forbidden by name. A word is on it if it

  - has no effect that outlives the question: no files, processes, threads, flags, global variables,
    operators, no asserting, no messages;
  - reaches no other module;
  - calls none of its arguments, or only such as can be checked before, to the bottom. Hence no
    call/1 of a variable: what is data when it is checked never becomes a goal;
  - does not catch: the exceptions that keep the limits must get through;
  - is bounded by the limits on time, inferences and stacks. Words that make numbers or atoms,
    which live outside the stacks, are called through bounded_numbers.pl and bounded_text.pl.

The arguments of a Head name themselves. An argument is

  - a name: a value;
  - goal(Name): a goal, whose variables may be asked for;
  - inner(Name): a goal, whose variables get no values;
  - bag(Name): a goal of bagof or setof, perhaps behind Var^;
  - closure(Extra, Name): a goal that lacks its last arguments;
  - hidden(Name): a value that is seen in the inner goals only;
  - expression(Name): arithmetic;
  - summary(Name): what aggregate_all works out.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(aggregate)).
:- use_module(library(solution_sequences)).
:- use_module(library(pairs)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog(vocabulary), []).

%!  allowed_word(+Goal, -Head) is semidet.
%
%   Goal calls the word that Head declares.

allowed_word(Goal, Head) :-
    functor(Goal, Name, Arity),
    functor(Head, Name, Arity),
    clause(allowed(Head, _), true),
    !.

%!  allowed(?Head, ?Meaning) is nondet.

% control
allowed(true, "always holds").
allowed(fail, "never holds").
allowed(false, "never holds").
allowed(!, "no other way is tried").
allowed((goal('A') , goal('B')), "both").
allowed((goal('A') ; goal('B')), "either").
allowed((goal('If') -> goal('Then')), "the first way of If, then Then").
allowed((goal('If') *-> goal('Then')), "all ways of If, then Then").
allowed(\+ inner('Goal'), "there is no way").
allowed(not(inner('Goal')), "there is no way").
allowed(once(goal('Goal')), "the first way only").
allowed(ignore(goal('Goal')), "the first way, or none").
allowed(forall(inner('If'), inner('Then')), "Then holds wherever If does").
allowed(call(goal('Goal')), "the goal, which must stand there").
allowed(call(closure(1, 'Goal'), 'A'), "the goal with one argument more").
allowed(call(closure(2, 'Goal'), 'A', 'B'), "the goal with two arguments more").
allowed(call(closure(3, 'Goal'), 'A', 'B', 'C'), "the goal with three arguments more").
% all solutions
allowed(findall(hidden('Template'), inner('Goal'), 'List'), "List has a Template for each way").
allowed(findall(hidden('Template'), inner('Goal'), 'List', 'Tail'), "the same, before Tail").
allowed(aggregate_all(summary('Summary'), inner('Goal'), 'Result'),
        "count, sum(X), max(X), min(X), max(X, Of), min(X, Of), bag(X), set(X) of all ways").
allowed(aggregate_all(summary('Summary'), hidden('Discriminator'), inner('Goal'), 'Result'),
        "the same, of those ways that differ in Discriminator").
allowed(bagof(hidden('Template'), bag('Goal'), 'List'),
        "List for each value of Goal's other variables").
allowed(setof(hidden('Template'), bag('Goal'), 'List'),
        "the same, sorted and without doubles").
allowed(limit('Count', goal('Goal')), "the first ways only").
allowed(offset('Count', goal('Goal')), "all but the first ways").
allowed(call_nth(goal('Goal'), 'N'), "the N-th way").
allowed(order_by('Specs', goal('Goal')), "the ways in order: [asc(X), desc(Y)]").
allowed(distinct(goal('Goal')), "each answer once").
allowed(distinct('Witness', goal('Goal')), "each Witness once").
% each of a list
allowed(maplist(closure(1, 'Goal'), 'List'), "Goal of every element").
allowed(maplist(closure(2, 'Goal'), 'List', 'List2'), "Goal of every two elements").
allowed(maplist(closure(3, 'Goal'), 'List', 'List2', 'List3'), "Goal of every three elements").
allowed(maplist(closure(4, 'Goal'), 'List', 'List2', 'List3', 'List4'),
        "Goal of every four elements").
allowed(foldl(closure(3, 'Goal'), 'List', 'First', 'Last'), "Goal(Element, Before, After) in turn").
allowed(foldl(closure(4, 'Goal'), 'List', 'List2', 'First', 'Last'), "the same of two lists").
allowed(foldl(closure(5, 'Goal'), 'List', 'List2', 'List3', 'First', 'Last'),
        "the same of three lists").
allowed(include(closure(1, 'Goal'), 'List', 'Included'), "the elements for which Goal holds").
allowed(exclude(closure(1, 'Goal'), 'List', 'Rest'), "the elements for which Goal does not hold").
allowed(partition(closure(1, 'Goal'), 'List', 'Included', 'Excluded'), "both").
allowed(predsort(closure(3, 'Order'), 'List', 'Sorted'), "sorted by Order(Sign, A, B)").
% comparing
allowed('X' = 'Y', "are the same, or become the same").
allowed('X' \= 'Y', "cannot become the same").
allowed('X' == 'Y', "are the same").
allowed('X' \== 'Y', "are not the same").
allowed('X' @< 'Y', "comes before, in the order of terms").
allowed('X' @> 'Y', "comes after").
allowed('X' @=< 'Y', "does not come after").
allowed('X' @>= 'Y', "does not come before").
allowed(compare('Order', 'X', 'Y'), "Order is <, = or >").
allowed(unify_with_occurs_check('X', 'Y'), "become the same, without cycles").
allowed(subsumes_term('General', 'Special'), "General can become Special").
% arithmetic
allowed('X' is expression('E'), "X is the value of E").
allowed(expression('A') =:= expression('B'), "are equal").
allowed(expression('A') =\= expression('B'), "are not equal").
allowed(expression('A') < expression('B'), "is less").
allowed(expression('A') > expression('B'), "is greater").
allowed(expression('A') =< expression('B'), "is not greater").
allowed(expression('A') >= expression('B'), "is not less").
allowed(between('Low', 'High', 'X'), "X is a whole number of that range").
allowed(succ('X', 'Y'), "Y is X + 1").
allowed(plus('X', 'Y', 'Z'), "Z is X + Y").
% kinds of terms
allowed(var('X'), "has no value yet").
allowed(nonvar('X'), "has a value").
allowed(atom('X'), "is a name").
allowed(number('X'), "is a number").
allowed(integer('X'), "is a whole number").
allowed(float('X'), "is a floating point number").
allowed(rational('X'), "is a whole number or a fraction").
allowed(string('X'), "is a string").
allowed(atomic('X'), "is a name, number or string").
allowed(compound('X'), "is a term with arguments").
allowed(callable('X'), "is a name or a term with arguments").
allowed(is_list('X'), "is a list").
allowed(ground('X'), "has no variables").
allowed(term_variables('X', 'Vars'), "Vars are its variables").
allowed(copy_term('X', 'Y'), "Y is X with fresh variables").
allowed(arg('N', 'Term', 'Arg'), "Arg is the N-th argument").
allowed(functor('Term', 'Name', 'Arity'), "what a term is called, and how many arguments it has").
allowed('Term' =.. 'List', "List is the name and the arguments").
% lists
allowed(length('List', 'N'), "how many elements").
allowed(member('X', 'List'), "X is an element").
allowed(memberchk('X', 'List'), "X is an element, the first that fits").
allowed(append('A', 'B', 'AB'), "AB is A, then B").
allowed(append('Lists', 'List'), "List is all of Lists in a row").
allowed(nth0('N', 'List', 'X'), "X is the N-th element, from 0").
allowed(nth1('N', 'List', 'X'), "X is the N-th element, from 1").
allowed(nth0('N', 'List', 'X', 'Rest'), "the same, with what remains").
allowed(nth1('N', 'List', 'X', 'Rest'), "the same, with what remains").
allowed(last('List', 'X'), "X is the last element").
allowed(reverse('List', 'Reversed'), "backwards").
allowed(flatten('Lists', 'List'), "without lists in lists").
allowed(msort('List', 'Sorted'), "sorted").
allowed(sort('List', 'Sorted'), "sorted, without doubles").
allowed(sort('Key', 'Order', 'List', 'Sorted'), "sorted by the Key-th argument").
allowed(keysort('Pairs', 'Sorted'), "sorted by key").
allowed(list_to_set('List', 'Set'), "without doubles").
allowed(max_member('X', 'List'), "the last in the order of terms").
allowed(min_member('X', 'List'), "the first in the order of terms").
allowed(max_list('Numbers', 'X'), "the greatest").
allowed(min_list('Numbers', 'X'), "the least").
allowed(sum_list('Numbers', 'Sum'), "their sum").
allowed(sumlist('Numbers', 'Sum'), "their sum").
allowed(numlist('Low', 'High', 'Numbers'), "the whole numbers of that range").
allowed(select('X', 'List', 'Rest'), "List without one X").
allowed(select('X', 'List', 'Y', 'List2'), "List with one X replaced by Y").
allowed(selectchk('X', 'List', 'Rest'), "List without the first X").
allowed(subtract('A', 'B', 'Rest'), "what is in A and not in B").
allowed(intersection('A', 'B', 'Both'), "what is in both").
allowed(union('A', 'B', 'Either'), "what is in one of them").
allowed(delete('List', 'X', 'Rest'), "List without all that fit X").
allowed(permutation('List', 'Other'), "the same elements in another order").
allowed(pairs_keys_values('Pairs', 'Keys', 'Values'), "Pairs are Key-Value").
allowed(pairs_keys('Pairs', 'Keys'), "their keys").
allowed(pairs_values('Pairs', 'Values'), "their values").
% text
allowed(atom_length('Text', 'N'), "how many characters").
allowed(string_length('Text', 'N'), "how many characters").
allowed(atom_concat('A', 'B', 'AB'), "AB is A, then B").
allowed(string_concat('A', 'B', 'AB'), "the same, as a string").
allowed(atomic_list_concat('Parts', 'Atom'), "Atom is all parts in a row").
allowed(atomic_list_concat('Parts', 'Separator', 'Atom'),
        "the same, separated; or the parts of Atom").
allowed(sub_atom('Atom', 'Before', 'Length', 'After', 'Sub'), "Sub is a piece of Atom").
allowed(sub_string('String', 'Before', 'Length', 'After', 'Sub'), "Sub is a piece of String").
allowed(atom_string('Atom', 'String'), "the same text").
allowed(atom_number('Atom', 'Number'), "Atom is the text of Number").
allowed(number_string('Number', 'String'), "String is the text of Number").
allowed(number_codes('Number', 'Codes'), "Codes are the text of Number").
allowed(atom_codes('Atom', 'Codes'), "the codes of the characters").
allowed(atom_chars('Atom', 'Chars'), "the characters").
allowed(string_codes('String', 'Codes'), "the codes of the characters").
allowed(string_chars('String', 'Chars'), "the characters").
allowed(char_code('Char', 'Code'), "the code of a character").
allowed(split_string('String', 'Separators', 'Pad', 'Parts'), "Parts of String").
allowed(string_lower('Text', 'Lower'), "in small letters").
allowed(string_upper('Text', 'Upper'), "in capital letters").

%!  arithmetic(?Indicator) is nondet.
%
%   A function, or a constant, that expressions may use. None has a state: nothing is random.

arithmetic(Name/0) :-
    member(Name, [pi, e, inf, epsilon, max_tagged_integer, min_tagged_integer]).
arithmetic(Name/1) :-
    member(Name, [-, +, abs, sign, sqrt, exp, log, log2, sin, cos, tan, asin, acos, atan, sinh,
                  cosh, tanh, asinh, acosh, atanh, float, integer, truncate, round, ceiling, floor,
                  rational, rationalize, numerator, denominator, float_integer_part,
                  float_fractional_part, erf, erfc, lgamma, msb, \]).
arithmetic(Name/2) :-
    member(Name, [+, -, *, /, //, mod, rem, div, rdiv, min, max, **, ^, atan, atan2,
                  copysign, gcd, log, >>, <<, /\, \/, xor]).

%   A word of the list that a module of the library defines.

library_word(Module:Name/Arity) :-
    allowed(Head, _),
    functor(Head, Name, Arity),
    functor(General, Name, Arity),
    predicate_property(facetlog_white_list:General, imported_from(Module)),
    Module \== system.

%!  furnish(+Module) is det.
%
%   Module sees the words of the list and the vocabulary. It inherits from `system`, not from `user`, so
%   that nothing else gets in.

furnish(Module) :-
    forall(import_module(Module, Other), delete_import_module(Module, Other)),
    add_import_module(Module, system, start),
    module_property(vocabulary, exports(Words)),
    forall(member(Word, Words), @(import(vocabulary:Word), Module)),
    forall(library_word(Source:Word), @(import(Source:Word), Module)),
    @(import(facetlog_scene:fact/1), Module).
